// The visitor that lists the keys of parameter structs and writes the page of parameters.
#include "deformable_surface/base/params.h"

#include "params_text.h"

namespace deformable_surface {

namespace {

// One row per key. Rows of a top-level section stand together, in whatever order they were visited.
class Page : public Fields {
 public:
  std::vector<std::string> keys;

  std::string text() const {
    std::string all;
    for (const Section& section : sections_) {
      if (section.rows.empty()) continue;
      all += "\n## " + section.title + "\n\n" + section.meaning +
             "\n\n| key | default | unit | accepted | meaning |\n|---|---|---|---|---|\n";
      all += section.rows;
    }
    return all;
  }

 private:
  struct Section {
    std::string title, meaning, rows;
  };

  void addRow(const About& about, const std::string& standard, const std::string& accepted) {
    const std::string key = joinPath(path_.back(), about.name);
    keys.push_back(key);
    sections_[path_.size() == 1 ? 0 : sections_.size() - 1].rows +=
        "| `" + key + "` | " + (about.required ? "must be given" : "`" + standard + "`") + " | " + about.unit + " | " +
        escapeBars(accepted) + " | " + escapeBars(about.meaning) + " |\n";
  }

  /// A bar would end a cell, also in code.
  static std::string escapeBars(const std::string& text) {
    std::string escaped;
    for (const char c : text) escaped += c == '|' ? "\\|" : std::string(1, c);
    return escaped;
  }

  void onNumber(const About& about, double& value) override { addRow(about, toShortText(value), about.range.describe()); }
  void onNumberOrAuto(const About& about, OrAuto<double>& value) override {
    addRow(about, value.is_auto ? "auto" : toShortText(value.value), "`auto`, or " + about.range.describe());
  }
  void onInteger(const About& about, Index& value) override {
    addRow(about, std::to_string(value), "an integer, " + about.range.describe());
  }
  void onFlag(const About& about, bool& value) override { addRow(about, value ? "true" : "false", "`true`, `false`"); }
  void onFlagOrAuto(const About& about, OrAuto<bool>& value) override {
    addRow(about, value.is_auto ? "auto" : value.value ? "true" : "false", "`auto`, `true`, `false`");
  }
  void onText(const About& about, std::string& value) override { addRow(about, "\"" + value + "\"", "text"); }
  void onVector(const About& about, double* value, int size) override {
    std::vector<std::string> numbers;
    for (int i = 0; i < size; ++i) numbers.push_back(toShortText(value[i]));
    addRow(about, "[" + join(numbers, ", ") + "]", std::to_string(size) + " numbers, each " + about.range.describe());
  }
  void onRows(const About& about, Points&) override {
    addRow(about, "[]", "a list of lists of 3 numbers, each " + about.range.describe());
  }
  void onChoice(const About& about, int& chosen, const std::vector<std::string>& accepted, const Value&) override {
    addRow(about, accepted[chosen], "`" + join(accepted, "`, `") + "`");
  }
  void onBounds(const About& about, std::vector<NamedBounds>&, const std::vector<std::string>& known) override {
    addRow(about, "{}",
           "a map from quantities to [min, max], `.inf` and `-.inf` for one side; the quantities: `" + join(known, "`, `") + "`");
  }
  bool onBegin(const About& about, bool) override {
    enter(about, joinPath(path_.back(), about.name));
    return true;
  }
  void onEnd() override { path_.pop_back(); }
  std::size_t onBeginList(const About& about, std::size_t) override {
    enter(about, joinPath(path_.back(), about.name) + "[]");
    return 1;
  }
  bool onBeginItem(std::size_t) override {
    path_.push_back(path_.back());
    return true;
  }
  void onEndList() override { onEnd(); }
  void onBroken(const std::string&, const std::string&) override {}

  void enter(const About& about, const std::string& path) {
    keys.push_back(joinPath(path_.back(), about.name));
    if (path_.size() == 1) sections_.push_back({about.name, about.meaning, ""});
    path_.push_back(path);
  }

  std::vector<std::string> path_{""};
  std::vector<Section> sections_{{"Top level", "Keys outside any section.", ""}};
};

}  // namespace

std::vector<std::string> internal::listKeys(const Visit& visit_defaults) {
  Page page;
  visit_defaults(page);
  return page.keys;
}

std::string internal::tabulateFields(const Visit& visit_defaults) {
  Page page;
  visit_defaults(page);
  return page.text();
}

}  // namespace deformable_surface
