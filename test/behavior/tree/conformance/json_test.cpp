// Values of a program's own types as JSON: "json:{...}" in XML and in entries, and back.

#include "musher/behavior/tree/json/json_fields.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_json_test {

struct Pallet {
  double x_m = 0;
  double y_m = 0;
};
struct Number {
  std::int64_t n = 0;
};
struct Large {
  std::uint64_t n = 0;
};
struct Small {
  float f = 0;
};
struct Preset {
  std::vector<int> steps{1, 2};
};
struct Task {
  std::string name;
  int count = 0;
  bool fast = false;
  Pallet place{};
  std::vector<double> speeds{};
  std::vector<Pallet> stops{};
};

}  // namespace musher::tree::conformance_json_test

using musher::tree::conformance_json_test::Pallet;

// [fields]
template <>
struct musher::tree::Convert<Pallet> : musher::tree::JsonFields<Pallet> {
  static constexpr std::string_view kName = "Pallet";
  static void Fields(auto& json, auto& pallet) {
    json("x_m", pallet.x_m);
    json("y_m", pallet.y_m);
  }
};
// [fields end]
template <>
struct musher::tree::Convert<musher::tree::conformance_json_test::Number>
    : musher::tree::JsonFields<musher::tree::conformance_json_test::Number> {
  static constexpr std::string_view kName = "Number";
  static void Fields(auto& json, auto& number) { json("n", number.n); }
};
template <>
struct musher::tree::Convert<musher::tree::conformance_json_test::Large>
    : musher::tree::JsonFields<musher::tree::conformance_json_test::Large> {
  static constexpr std::string_view kName = "Large";
  static void Fields(auto& json, auto& number) { json("n", number.n); }
};
template <>
struct musher::tree::Convert<musher::tree::conformance_json_test::Small>
    : musher::tree::JsonFields<musher::tree::conformance_json_test::Small> {
  static constexpr std::string_view kName = "Small";
  static void Fields(auto& json, auto& number) { json("f", number.f); }
};
template <>
struct musher::tree::Convert<musher::tree::conformance_json_test::Preset>
    : musher::tree::JsonFields<musher::tree::conformance_json_test::Preset> {
  static constexpr std::string_view kName = "Preset";
  static void Fields(auto& json, auto& preset) { json("steps", preset.steps); }
};
template <>
struct musher::tree::Convert<musher::tree::conformance_json_test::Task>
    : musher::tree::JsonFields<musher::tree::conformance_json_test::Task> {
  static constexpr std::string_view kName = "Task";
  static void Fields(auto& json, auto& task) {
    json("name", task.name);
    json("count", task.count);
    json("fast", task.fast);
    json("place", task.place);
    json("speeds", task.speeds);
    json("stops", task.stops);
  }
};

namespace musher::tree::conformance_json_test {

using testing::HasSubstr;

using Tasks = Convert<Task>;

std::string ErrorOf(std::string_view json) {
  const auto task = Tasks::FromJson(json);
  return task ? "" : task.error().message;
}

// Adds the coordinates of `at` into `sum`, and passes `at` on.
class Look : public Action {
 public:
  explicit Look(Setup& setup)
      : at_(setup.Input<Pallet>("at")),
        sum_(setup.Output<double>("sum")),
        same_(setup.Output<Pallet>("same")) {}

 private:
  Status Do(const Tick&) override {
    sum_.Set(at_.Get().x_m + at_.Get().y_m);
    same_.Set(at_.Get());
    return Status::kSuccess;
  }
  InPort<Pallet> at_;
  OutPort<double> sum_;
  OutPort<Pallet> same_;
};

struct JsonPorts : testing::Test {
  JsonPorts() { EXPECT_TRUE(factory.Add<Look>("Look")); }
  Factory factory;
};

TEST_F(JsonPorts, TakeALiteral) {
  const auto tree = MakeTree(
      Main("<Look at='json:{\"x_m\": 1.5, \"y_m\": 2}' sum=\"{sum}\" same=\"{same}\"/>"), factory);
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<double>("sum").value(), 3.5);
  EXPECT_EQ(tree->board().Find("same")->value.Shown(), "{\"x_m\":1.5,\"y_m\":2}");
}
TEST_F(JsonPorts, TakeATextOfAnEntry) {
  const auto set = MakeTree(Main("<Look at=\"{at}\" sum=\"{sum}\"/>"), factory);
  ASSERT_TRUE(set->board().Set("at", "json:{\"x_m\":3,\"y_m\":4}"));
  EXPECT_EQ(Ticks(*set, 1), "S");
  EXPECT_EQ(set->board().Get<double>("sum").value(), 7);
  const Result<> wrong = set->board().Set("at", "json:{\"x_m\":3}");
  EXPECT_EQ(wrong.error().message, "the JSON field 'y_m' is missing");
  EXPECT_THAT(set->board().Set("at", "3;4").error().message,
              HasSubstr("expected Pallet as JSON, such as json:{...}"));
}
TEST_F(JsonPorts, TakeALiteralOfASubtree) {
  const auto tree = MakeTree(
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">"
      "<SubTree ID=\"Part\" place='json:{\"x_m\":1,\"y_m\":1}' sum=\"{=}\"/></BehaviorTree>"
      "<BehaviorTree ID=\"Part\"><Look at=\"{place}\" sum=\"{sum}\"/></BehaviorTree></root>",
      factory);
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<double>("sum").value(), 2);
}
TEST_F(JsonPorts, ReportAWrongLiteralWhenLoading) {
  EXPECT_EQ(Findings(Main("<Look at='json:{\"x_m\": 1}'/>"), factory),
            "t.xml:3:11: error: port 'at': the JSON field 'y_m' is missing\n");
  EXPECT_THAT(Findings(Main("<Look at='json:{'/>"), factory), HasSubstr("it is no JSON"));
  EXPECT_THAT(Findings(Main("<Look at=\"1;2\"/>"), factory), HasSubstr("or JSON"));
}

TEST(Json, OfATypeReadsWhatItWrites) {
  const Task task{.name = "a \"b\"\n\u00e9",
                  .count = -3,
                  .fast = true,
                  .place = {0.1, 1e300},
                  .speeds = {1, 2.5},
                  .stops = {{1, 2}, {3, 4}}};
  const std::string json = Tasks::ToJson(task);
  const auto again = Tasks::FromJson(json);
  ASSERT_TRUE(again) << again.error().message << json;
  EXPECT_EQ(Tasks::ToJson(again.value()), json);
  EXPECT_EQ(again.value().name, task.name);
  EXPECT_EQ(again.value().place.y_m, 1e300);
  EXPECT_EQ(Tasks::ToJson(Task{}),
            "{\"name\":\"\",\"count\":0,\"fast\":false,\"place\":{\"x_m\":0,\"y_m\":0},"
            "\"speeds\":[],\"stops\":[]}");
}
TEST(Json, KeepsWholeNumbersExactly) {
  for (const std::int64_t number : {(std::int64_t{1} << 53) + 1, INT64_MAX, INT64_MIN}) {
    const std::string json = Convert<Number>::ToJson({number});
    EXPECT_EQ(json, "{\"n\":" + std::to_string(number) + "}");
    EXPECT_EQ(Convert<Number>::FromJson(json).value().n, number);
  }
  EXPECT_FALSE(Convert<Number>::FromJson("{\"n\":9223372036854775808}"));
}
TEST(Json, KeepsWholeNumbersFrom0UpToTheLargest) {
  for (const std::uint64_t number : {std::uint64_t{0}, std::uint64_t{INT64_MAX} + 1, UINT64_MAX}) {
    const std::string json = Convert<Large>::ToJson({number});
    const auto again = Convert<Large>::FromJson(json);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again.value().n, number);
  }
  EXPECT_EQ(Convert<Large>::FromJson("{\"n\":2.0}").value().n, 2);
  EXPECT_EQ(Convert<Large>::FromJson("{\"n\":-1}").error().message,
            "the JSON field 'n' is number; expected integer from 0");
  EXPECT_FALSE(Convert<Large>::FromJson("{\"n\":18446744073709551616}"));
}
TEST(Json, RefusesANumberThatAFloatCanNotHave) {
  EXPECT_EQ(Convert<Small>::FromJson("{\"f\":-1e300}").error().message,
            "the JSON field 'f' is number; expected a number that a float can have");
  EXPECT_EQ(Convert<Small>::FromJson("{\"f\":1e30}").value().f, 1e30F);
}
TEST(Json, ReplacesWhatAConstructorPutsIntoAList) {
  EXPECT_EQ(Convert<Preset>::FromJson("{\"steps\":[3]}").value().steps, std::vector<int>{3});
  EXPECT_TRUE(Convert<Preset>::FromJson("{\"steps\":[]}").value().steps.empty());
}
TEST(Json, NamesTheFieldThatIsWrong) {
  Task task;
  task.stops = {{1, 2}};
  const std::string good = Tasks::ToJson(task);
  EXPECT_EQ(ErrorOf(good), "");
  const auto with = [&good](const std::string& from, const std::string& to) {
    std::string json = good;
    return ErrorOf(json.replace(json.find(from), from.size(), to));
  };
  EXPECT_EQ(with("\"count\":0", "\"count\":0.5"),
            "the JSON field 'count' is number; expected a whole number");
  EXPECT_EQ(with("\"count\":0", "\"count\":1e99"),
            "the JSON field 'count' is number; expected a whole number");
  EXPECT_EQ(with("\"count\":0", "\"count\":2147483648"),
            "the JSON field 'count' is number; expected integer");
  EXPECT_EQ(with("\"count\":0", "\"count\":2.0"), "");
  EXPECT_EQ(with("false", "1"), "the JSON field 'fast' is number; expected true or false");
  EXPECT_EQ(with("\"\"", "null"), "the JSON field 'name' is null; expected a text");
  EXPECT_EQ(with("[]", "[1,true]"), "the JSON field 'speeds[1]' is boolean; expected a number");
  EXPECT_EQ(with("\"y_m\":2", "\"z_m\":2"), "the JSON field 'stops[0].y_m' is missing");
  EXPECT_EQ(with("\"y_m\":2", "\"y_m\":2,\"z_m\":2"),
            "the JSON field 'stops[0]' has an unknown field 'z_m'");
  EXPECT_EQ(ErrorOf("[]"), "the JSON is array; expected an object with fields");
  EXPECT_EQ(ErrorOf(std::string(5000, '[')),
            "the JSON is larger than 1 MiB, or nested deeper than 100");
}

}  // namespace musher::tree::conformance_json_test
