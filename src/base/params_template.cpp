// The visitor that writes a map with every value and its meaning above it: a template.
#include "deformable_surface/base/params.h"

#include "params_text.h"

#include <algorithm>

namespace deformable_surface {

namespace {

constexpr std::size_t kWidth = 110;  // letters of a line of comment

class Template : public Fields {
 public:
  const std::string& text() const { return text_; }

 private:
  // Items of lists are examples: they are in comments, with their meaning after the value.
  void put(const About& about, const std::string& value, const std::string& accepted) {
    std::string meaning = about.meaning;
    if (about.required && is_example_) meaning = join({"must be given", meaning}, meaning.empty() ? "" : ": ");
    if (*about.unit) meaning += std::string(meaning.empty() ? "" : "; ") + about.unit;
    if (!accepted.empty()) meaning += (meaning.empty() ? "" : "; ") + accepted;
    if (is_example_) {
      text_ += "# " + indent_ + about.name + ": " + value + "  # " + meaning + "\n";
      return;
    }
    comment(meaning);
    text_ += indent_ + about.name + ": " + value + "\n";
  }

  // In lines that break between words.
  void comment(const std::string& words) {
    std::string line;
    for (std::size_t begin = 0; begin < words.size();) {
      const std::size_t end = std::min(words.find(' ', begin), words.size());
      if (!line.empty() && indent_.size() + line.size() + end - begin > kWidth) {
        text_ += indent_ + "#" + line + "\n";
        line.clear();
      }
      line += " " + words.substr(begin, end - begin);
      begin = end + 1;
    }
    if (!line.empty()) text_ += indent_ + "#" + line + "\n";
  }

  static std::string asLine(const Value& value) {
    const std::string yaml = toYaml(value);
    return yaml.substr(0, yaml.size() - 1);
  }

  void onNumber(const About& about, double& value) override { put(about, formatReal(value), about.range.describe()); }
  void onNumberOrAuto(const About& about, OrAuto<double>& value) override {
    put(about, value.is_auto ? "auto" : formatReal(value.value), "auto, or " + about.range.describe());
  }
  void onInteger(const About& about, Index& value) override {
    put(about, std::to_string(value), "an integer, " + about.range.describe());
  }
  void onFlag(const About& about, bool& value) override { put(about, value ? "true" : "false", "true or false"); }
  void onFlagOrAuto(const About& about, OrAuto<bool>& value) override {
    put(about, value.is_auto ? "auto" : value.value ? "true" : "false", "auto, true or false");
  }
  void onText(const About& about, std::string& value) override { put(about, asLine(Value(value)), "text"); }
  void onVector(const About& about, double* value, int size) override {
    put(about, asLine(Value::List(value, value + size)), "each " + about.range.describe());
  }
  void onRows(const About& about, Points&) override { put(about, "[]", "lists of 3 numbers, each " + about.range.describe()); }
  void onChoice(const About& about, int& chosen, const std::vector<std::string>& accepted, const Value&) override {
    put(about, accepted[chosen], "one of " + join(accepted, ", "));
  }
  void onBounds(const About& about, std::vector<NamedBounds>& value, const std::vector<std::string>& known) override {
    put(about, value.empty() ? "{}" : "", "quantities with [min, max]: " + join(known, ", "));
    for (const NamedBounds& bound : value)
      text_ += indent_ + "  " + bound.name + ": [" + formatReal(bound.min) + ", " + formatReal(bound.max) + "]\n";
  }
  bool onBegin(const About& about, bool) override {
    if (is_example_) {
      text_ += "# " + indent_ + about.name + ":" + (*about.meaning ? std::string("  # ") + about.meaning : "") + "\n";
    } else {
      text_ += "\n";
      comment(about.meaning);
      text_ += indent_ + about.name + ":\n";
    }
    indent_ += "  ";
    return true;
  }
  void onEnd() override { indent_.resize(indent_.size() - 2); }
  std::size_t onBeginList(const About& about, std::size_t) override {
    was_example_.push_back(is_example_);
    if (is_example_) {
      text_ += "# " + indent_ + about.name + ":  # " + about.meaning + "\n";
    } else {
      text_ += "\n";
      comment(std::string(about.meaning) + " An item has these keys:");
      // The list itself stands below its example.
      list_ = indent_ + about.name + ": []\n";
      is_example_ = true;
    }
    indent_ += "  ";
    return 1;
  }
  bool onBeginItem(std::size_t) override {
    text_ += "# " + indent_ + "-\n";
    indent_ += "  ";
    return true;
  }
  void onEndList() override {
    onEnd();
    is_example_ = was_example_.back();
    was_example_.pop_back();
    if (!is_example_) text_ += list_;
  }
  void onBroken(const std::string&, const std::string&) override {}

  std::string text_, indent_, list_;
  bool is_example_ = false;
  std::vector<char> was_example_;
};

}  // namespace

std::string internal::writeTemplate(const Visit& visit_params) {
  Template page;
  visit_params(page);
  return page.text();
}

}  // namespace deformable_surface
