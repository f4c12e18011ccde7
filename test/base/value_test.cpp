// The value tree and the machinery of parameters: numbers as text, printing, reading with every problem named.
#include "deformable_surface/base/value.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/params.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace deformable_surface;

namespace {

struct InnerParams {
  double weight = 1.0;
};

void visit(Fields& fields, InnerParams& p) { fields.number("weight", p.weight, "kg", strictlyBetween(0.0, 10.0), "a weight"); }

struct OuterParams {
  std::string name = "none";
  Index count = 3;
  bool flag = true;
  OrAuto<double> width;
  OrAuto<bool> sign;
  InnerParams inner;
  std::vector<InnerParams> items;
};

void visit(Fields& fields, OuterParams& p) {
  fields.text("name", p.name, "a name");
  fields.integer("count", p.count, "", between(1, 5), "a count");
  fields.flag("flag", p.flag, "a flag");
  fields.number("width", p.width, "m", between(0.0, 1.0), "a width");
  fields.flag("sign", p.sign, "a sign");
  fields.section("inner", p.inner, "A section.");
  fields.list("items", p.items, "Items.");
  fields.require(p.count != 4, "count", "found 4; accepted: others");
}

enum class Color { kRed, kBlue };

struct ChoiceParams {
  Color color = Color::kRed;
  std::string shape = "round";
};

void visit(Fields& fields, ChoiceParams& p) {
  fields.choice("color", p.color, {{"red", Color::kRed}, {"blue", Color::kBlue}}, "a colour");
  // As rules that look a value up in a table.
  constexpr bool kIsRed[] = {true, false};
  const bool is_red = kIsRed[static_cast<int>(p.color)];
  fields.choice<std::string>("shape", p.shape, {{"round", "round"}, {"square", "square"}}, "a shape");
  fields.require(!is_red || p.shape != "square", "", "found a red square; accepted: a blue one");
}

Value makeMap(const std::string& key, Value value) { return Value::Map{{key, std::move(value)}}; }

std::vector<std::string> problemsOf(const Value& value) {
  OuterParams params;
  return readParams(value, params);
}

}  // namespace

TEST(ParseNumber, TakesDecimalsInEveryUsualForm) {
  EXPECT_EQ(*parseNumber("3").asInteger(), 3);
  EXPECT_EQ(*parseNumber("-17").asInteger(), -17);
  EXPECT_EQ(*parseNumber("+4").asInteger(), 4);
  EXPECT_EQ(*parseNumber("1e5").asReal(), 1e5);
  EXPECT_EQ(*parseNumber("-2.5E-3").asReal(), -2.5e-3);
  EXPECT_EQ(*parseNumber(".5").asReal(), 0.5);
  EXPECT_EQ(*parseNumber("5.").asReal(), 5.0);
  EXPECT_EQ(*parseNumber("99999999999999999999").asReal(), 1e20);
  EXPECT_TRUE(std::isinf(*parseNumber("-.inf").asReal()));
  EXPECT_TRUE(std::isinf(*parseNumber("1e999").asReal()));
  EXPECT_TRUE(std::isnan(*parseNumber(".nan").asReal()));
}

TEST(ParseNumber, RefusesWhatIsNoDecimal) {
  for (const char* text : {"", "-", ".", "1e", "e5", "0x10", "012", "1_000", "1:30", "1,5", " 1", "1 ", "one", "1e5x", "--1"}) {
    EXPECT_TRUE(parseNumber(text).isNull()) << text;
  }
}

TEST(ParseScalar, TellsKindsApart) {
  EXPECT_TRUE(parseScalar("~").isNull());
  EXPECT_TRUE(*parseScalar("true").asBool());
  EXPECT_EQ(*parseScalar("yes").asText(), "yes");
  EXPECT_EQ(*parseScalar("nan").asText(), "nan");
  EXPECT_EQ(*parseScalar("012").asText(), "012");
  EXPECT_EQ(*parseScalar("7").asInteger(), 7);
}

TEST(FormatReal, ReadsBackAsTheSameBits) {
  for (const double value :
       {0.0, 1.0, -9.81, 0.1, 1.0 / 3.0, 1e5, 1e-300, 123456789.0, 2e7, 5e-324, std::numeric_limits<double>::max(), 0.1 + 0.2}) {
    const std::string text = formatReal(value);
    const Value back = parseScalar(text);
    ASSERT_TRUE(back.asReal()) << text;
    EXPECT_EQ(*back.asReal(), value) << text;
  }
  EXPECT_EQ(formatReal(1e9), "1.0e+09");
  EXPECT_EQ(formatReal(0.1), "0.1");
}

TEST(Value, DescribesItselfWithoutControlCharacters) {
  EXPECT_EQ(Value().describe(), "nothing");
  EXPECT_EQ(Value(-1).describe(), "-1");
  EXPECT_EQ(Value("a\nb").describe(), "the text 'a?b'");
  EXPECT_LT(Value(std::string(1000, 'x')).describe().size(), 100u);
}

TEST(ToYaml, QuotesTextThatWouldReadAsSomethingElse) {
  EXPECT_EQ(toYaml("mass_spring"), "mass_spring\n");
  for (const char* text : {"true", "no", "1e5", "", "a: b", "#x", "null"}) EXPECT_EQ(toYaml(text)[0], '"') << text;
  EXPECT_EQ(toYaml("a\"b\\c\n"), "\"a\\\"b\\\\c\\x0a\"\n");
}

TEST(EditDistance, CountsSwapsAsOne) {
  EXPECT_EQ(editDistance("", "abc"), 3);
  EXPECT_EQ(editDistance("kitten", "sitting"), 3);
  EXPECT_EQ(editDistance("densiyt", "density"), 1);
  EXPECT_EQ(nearestWord("dampng", {"density", "damping"}), "damping");
}

TEST(Range, RefusesNanAndOpenEnds) {
  EXPECT_FALSE(anyFinite().contains(std::nan("")));
  EXPECT_FALSE(anyFinite().contains(std::numeric_limits<double>::infinity()));
  EXPECT_TRUE(between(0.0, 1.0).contains(1.0));
  EXPECT_FALSE(strictlyBetween(0.0, 1.0).contains(1.0));
  EXPECT_EQ(strictlyBetween(-1.0, 0.5).describe(), "above -1 and below 0.5");
  EXPECT_EQ(between(1e-9, 1e9).describe(), "1e-9 to 1e9");
}

TEST(ReadParams, KeepsDefaultsOfWhatIsNotNamed) {
  OuterParams params;
  EXPECT_TRUE(readParams(makeMap("width", 0.25), params).empty());
  EXPECT_EQ(params.width.valueOr(9.0), 0.25);
  EXPECT_EQ(params.count, 3);
}

TEST(ReadParams, TakesNumbersAsTextAndWholeRealsAsIntegers) {
  OuterParams params;
  const Value value = Value::Map{{"count", "2.0"}, {"inner", makeMap("weight", "2.5e0")}, {"width", "auto"}};
  EXPECT_TRUE(readParams(value, params).empty());
  EXPECT_EQ(params.count, 2);
  EXPECT_EQ(params.inner.weight, 2.5);
}

TEST(ReadParams, TakesAFlagOrAuto) {
  OuterParams params;
  EXPECT_TRUE(readParams(makeMap("sign", false), params).empty());
  EXPECT_FALSE(params.sign.valueOr(true));
  EXPECT_EQ(*printParams(params).find("sign")->asBool(), false);
  EXPECT_TRUE(readParams(makeMap("sign", "auto"), params).empty());
  EXPECT_TRUE(params.sign.is_auto);
  EXPECT_EQ(*printParams(params).find("sign")->asText(), "auto");
  const std::vector<std::string> problems = problemsOf(makeMap("sign", "on"));
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0], "sign: found the text 'on'; accepted: auto, true or false");
}

TEST(ReadParams, NamesEveryProblemAtOnce) {
  const Value value = Value::Map{{"name", 5},
                                 {"count", 2.5},
                                 {"flag", 1},
                                 {"width", 2},
                                 {"inner", Value::Map{{"weight", 0}, {"wieght", 1}}},
                                 {"items", Value::List{Value::Map{{"weight", std::nan("")}}, 7}}};
  const std::vector<std::string> problems = problemsOf(value);
  ASSERT_EQ(problems.size(), 8u);
  EXPECT_EQ(problems[0], "name: found 5; accepted: text (in quotes if it looks like something else)");
  EXPECT_EQ(problems[1], "count: found 2.5; accepted: an integer, 1 to 5");
  EXPECT_EQ(problems[2], "flag: found 1; accepted: true or false");
  EXPECT_EQ(problems[3], "width: found 2; accepted: auto, or 0 to 1 (m)");
  EXPECT_EQ(problems[4], "inner.weight: found 0; accepted: above 0 and below 10 (kg)");
  EXPECT_EQ(problems[5], "inner.wieght: unknown key; the nearest known one is inner.weight");
  EXPECT_EQ(problems[6], "items[0].weight: found .nan; accepted: above 0 and below 10 (kg)");
  EXPECT_EQ(problems[7], "items[1]: found 7; accepted: a map");
}

TEST(ReadParams, FindsTheNearestKeyInAnotherSection) {
  ASSERT_EQ(problemsOf(makeMap("weight", 1)).size(), 1u);
  EXPECT_EQ(problemsOf(makeMap("weight", 1))[0], "weight: unknown key; the nearest known one is inner.weight");
}

TEST(ReadParams, ListsTheKeysOfTheSectionWhereNoneIsNear) {
  EXPECT_EQ(problemsOf(Value::Map{{"inner", Value::Map{{"weight", 1}, {"foo", 1}}}})[0],
            "inner.foo: unknown key; accepted: weight");
}

TEST(ReadParams, JudgesRulesOnlyOverReadableFields) {
  EXPECT_EQ(problemsOf(makeMap("count", 4)).size(), 1u);
  EXPECT_EQ(problemsOf(Value::Map{{"count", 4}, {"flag", "x"}}).size(), 1u);
}

TEST(CheckParams, FindsWhatAProgramSetWrong) {
  OuterParams params;
  EXPECT_TRUE(checkParams(params).empty());
  params.items.resize(2);
  params.items[1].weight = std::nan("");
  params.count = 0;
  EXPECT_EQ(checkParams(params).size(), 2u);
}

TEST(CheckParams, TellsAValueThatIsNoneOfTheChoices) {
  ChoiceParams params;
  params.color = static_cast<Color>(1000000000);
  params.shape = "square";
  EXPECT_EQ(checkParams(params), std::vector<std::string>{"color: found 1000000000; accepted: red, blue"});
  params.color = Color::kBlue;
  EXPECT_TRUE(checkParams(params).empty());
  params.shape = "flat";
  EXPECT_EQ(checkParams(params), std::vector<std::string>{"shape: found the text 'flat'; accepted: round, square"});
}

TEST(CheckParams, TellsARuleOfTheWholeWithoutAKey) {
  ChoiceParams params;
  params.shape = "square";
  EXPECT_EQ(checkParams(params), std::vector<std::string>{"found a red square; accepted: a blue one"});
}

TEST(Quote, ShowsWholeCharactersAndNoneThatATerminalObeys) {
  EXPECT_EQ(quote("a\x1b[2J\nb\x7f"), "'a?[2J?b?'");
  EXPECT_EQ(quote("\u00fcber"), "'\u00fcber'");
  EXPECT_EQ(quote("\xc3("), "'?('");                                  // cut UTF-8
  EXPECT_EQ(quote("\xc2\x9b!"), "'" + std::string(2, '?') + "!'");    // a control character of two bytes
  EXPECT_EQ(quote("\xed\xa0\x80"), "'" + std::string(3, '?') + "'");  // a surrogate
  // Cut between characters.
  EXPECT_EQ(quote(std::string(59, 'a') + "\u00fc" + "b"), "'" + std::string(59, 'a') + "...'");
}

TEST(InputError, ShowsNoCharacterThatATerminalObeys) {
  const InputError error(std::vector<std::string>{"a\tb", "c\x1b[1m"});
  EXPECT_STREQ(error.what(), "a?b\nc?[1m");
  EXPECT_EQ(error.problems()[1], "c?[1m");
}

TEST(ToOneLine, JoinsLinesAndHasABound) {
  EXPECT_EQ(toOneLine(""), "");
  EXPECT_EQ(toOneLine("one\ntwo\n"), "one; two");
  EXPECT_EQ(toOneLine("one\r\ntwo"), "one?; two");
  const std::string sentence(150, 's');
  std::string all = sentence;
  for (int k = 0; k < 7; ++k) all += "\n" + sentence;
  EXPECT_EQ(toOneLine(all), sentence + "; " + sentence + "; and 6 more");
  EXPECT_LE(toOneLine(std::string(100000, 'x')).size(), 410u);
  EXPECT_EQ(toOneLine(std::string(100000, 'x')).substr(400), "...");
  const std::string words = std::string(250, 'a') + " b; c " + std::string(140, 'd') + " e";
  EXPECT_EQ(toOneLine(words + "f; g"), std::string(250, 'a') + " b...");
  EXPECT_EQ(toOneLine(std::string(300, 'a') + " " + std::string(150, 'b')), std::string(300, 'a') + "...");
}

TEST(FormatShort, GivesNoSignToWhatIsNoNumber) {
  EXPECT_EQ(formatShort(-std::nan("")), "nan");
  EXPECT_EQ(formatShort(std::nan("")), "nan");
}
