// A network of a few layers, which is written here byte by byte, and what a detector of kind net
// makes of it. Its input has 32 x 32 pixels, in 4 x 4 cells: of each cell it says a box of 16 x 16
// pixels around its middle, that it is red by so much, and that it is green by so much.

#include "musher/modules/vision/course/net_finder.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/test/modules/vision/course_pictures.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::vision::net_detector_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Protocol buffers: fields with a number, of bytes or of an integer.
std::string Varint(std::uint64_t number) {
  std::string bytes;
  for (; number >= 128; number >>= 7) bytes += char(number | 128);
  return bytes + char(number);
}

std::string Field(int number, const std::string& bytes) {
  return Varint(std::uint64_t(number) * 8 + 2) + Varint(bytes.size()) + bytes;
}

std::string Field(int number, std::int64_t integer) {
  return Varint(std::uint64_t(number) * 8) + Varint(std::uint64_t(integer));
}

template <class T>
std::string Raw(const std::vector<T>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)};
}

using Shape = std::vector<std::int64_t>;

// The messages of ONNX: their numbers are those of its onnx.proto.
std::string Tensor(const std::string& name, const Shape& shape, int type, const std::string& raw) {
  std::string tensor;
  for (const std::int64_t size : shape) tensor += Field(1, size);
  return tensor + Field(2, type) + Field(8, name) + Field(9, raw);
}

std::string Floats(const std::string& name, const Shape& shape, const std::vector<float>& numbers) {
  constexpr int kFloat = 1;
  return Field(5, Tensor(name, shape, kFloat, Raw(numbers)));
}

std::string ListOf(const std::string& name, const Shape& numbers) {
  constexpr int kIntegers = 7;
  std::string attribute = Field(1, name);
  for (const std::int64_t number : numbers) attribute += Field(8, number);
  return Field(5, attribute + Field(20, kIntegers));
}

std::string Node(const std::string& kind, const std::vector<std::string>& from,
                 const std::string& to, const std::string& attributes = "") {
  std::string node;
  for (const std::string& each : from) node += Field(1, each);
  return Field(1, node + Field(2, to) + Field(3, to + "_node") + Field(4, kind) + attributes);
}

std::string Value(int field, const std::string& name, const Shape& shape) {
  std::string sizes;
  for (const std::int64_t size : shape) sizes += Field(1, Field(1, size));
  return Field(field, Field(1, name) + Field(2, Field(1, Field(1, 1) + Field(2, sizes))));
}

std::string Model(const std::string& graph) {
  constexpr int kVersion = 7, kOperators = 12;
  return Field(1, kVersion) + Field(7, graph + Field(2, "test")) +
         Field(8, Field(1, "") + Field(2, kOperators));
}

constexpr int kSide = 32, kCell = 8, kCells = kSide / kCell, kNumbers = 7;

enum class Says { kRows, kColumns, kCells, kTwoOutputs };

// Objectness, and how red and how green a cell is: its mean of that channel less that of the other.
std::string CellsModel(Says says, float spoilt = 0) {
  const bool rows = says == Says::kRows;
  const int channels = rows ? kNumbers : kNumbers - 1;
  const int red = rows ? 5 : 4;
  std::vector<float> weights(std::size_t(channels * 3 * kCell * kCell));
  for (int i = 0; i < kCell * kCell; ++i) {
    const float share = 1.0F / (kCell * kCell);
    const auto at = [&](int channel, int of) -> float& {
      return weights[std::size_t((channel * 3 + of) * kCell * kCell + i)];
    };
    at(red, 0) = at(red + 1, 1) = share;
    at(red, 1) = at(red + 1, 0) = -share;
  }
  std::vector<float> places(std::size_t(channels * kCells * kCells));
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const auto at = [&](int channel) -> float& {
        return places[std::size_t((channel * kCells + y) * kCells + x)];
      };
      at(0) = float((x + 0.5) * kCell);
      at(1) = float((y + 0.5) * kCell);
      at(2) = at(3) = 16;
      if (rows) at(4) = 1;
    }
  }
  places.back() += spoilt;
  std::string graph =
      Node("Conv", {"picture", "weights"}, "colors",
           ListOf("kernel_shape", {kCell, kCell}) + ListOf("strides", {kCell, kCell})) +
      Node("Add", {"colors", "places"}, "cells") +
      Floats("weights", {channels, 3, kCell, kCell}, weights) +
      Floats("places", {1, channels, kCells, kCells}, places) +
      Value(11, "picture", {1, 3, kSide, kSide});
  if (says == Says::kCells) return Model(graph + Value(12, "cells", {1, channels, kCells, kCells}));
  constexpr int kInteger = 7;
  graph += Node("Reshape", {"cells", "flat"}, "columns") +
           Field(5, Tensor("flat", {3}, kInteger, Raw(Shape{1, channels, kCells * kCells})));
  if (says == Says::kTwoOutputs) {
    graph += Node("Relu", {"cells"}, "other") + Value(12, "other", {1, channels, kCells, kCells});
  }
  if (!rows) return Model(graph + Value(12, "columns", {1, channels, kCells * kCells}));
  graph += Node("Transpose", {"columns"}, "rows", ListOf("perm", {0, 2, 1}));
  return Model(graph + Value(12, "rows", {1, kCells * kCells, channels}));
}

class NetDetector : public ::testing::Test {
 protected:
  NetParameters With(const std::string& model) {
    NetParameters parameters;
    parameters.model = folder_ / "things.onnx";
    parameters.labels = {"red", "green"};
    parameters.width_px = parameters.height_px = kSide;
    std::ofstream(parameters.model, std::ios::binary) << model;
    return parameters;
  }

  std::string LoadError(const NetParameters& parameters) {
    const auto net = Net::Load(parameters);
    return net ? "" : net.error().message;
  }

  std::vector<std::string> Said(const std::string& parameters) {
    std::vector<std::string> said;
    const std::string file = folder_ / "course.toml";
    const auto reading = ReadVisionText(
        "[[detectors]]\nname = \"things\"\nkind = \"net\"\n[detectors.parameters]\n" + parameters,
        file);
    for (const Diagnostic& diagnostic : reading.diagnostics) {
      said.push_back(FormatDiagnostic(diagnostic).substr(folder_.path().size() + 1));
    }
    return said;
  }

  TempFolder folder_;
};

// A thing as large as one cell: the input shows the picture twenty times smaller, between two bars
// of 4 rows.
cv::Mat WithThing(const cv::Scalar& color, int left, int top, cv::Mat bgr = GreyPicture()) {
  bgr(cv::Rect(left, top, 160, 160)).setTo(color);
  return bgr;
}
const cv::Scalar kPureRed(0, 0, 255), kPureGreen(0, 255, 0);

TEST_F(NetDetector, FindsAThingWhereItIsByEitherLayout) {
  for (const Says says : {Says::kRows, Says::kColumns}) {
    const auto net = Net::Load(With(CellsModel(says)));
    ASSERT_TRUE(net) << net.error().message;
    const NetLook look = net.value()->Look(WithThing(kPureRed, 160, 80));
    ASSERT_FALSE(look.boxes.empty());
    const NetBox& best = look.boxes.front();
    EXPECT_EQ(best.label, 0U);
    EXPECT_NEAR(best.confidence, 1, 0.1);
    EXPECT_NEAR(best.box.x + best.box.width / 2, 240, 1);
    EXPECT_NEAR(best.box.y + best.box.height / 2, 160, 1);
    EXPECT_NEAR(best.box.width, 320, 1);
    EXPECT_TRUE(net.value()->Look(GreyPicture()).boxes.empty());
  }
}

TEST_F(NetDetector, SaysTheLabelAfterRepeats) {
  auto made = MakeNetDetector(With(CellsModel(Says::kRows)));
  ASSERT_TRUE(made) << made.error().message;
  CourseDetector& detector = *made.value();
  const cv::Mat bgr = WithThing(kPureGreen, 320, 80);
  const CourseSight first = detector.Look(bgr, 1, std::nullopt);
  EXPECT_TRUE(first.sighting->seen);
  EXPECT_EQ(first.sighting->text, "");
  EXPECT_TRUE(std::isnan(first.sighting->distance_m));
  const CourseSight second = detector.Look(bgr, 2, std::nullopt);
  EXPECT_EQ(second.text, "green");
  EXPECT_EQ(second.sighting->text, "green");
  EXPECT_NEAR(second.sighting->x + second.sighting->width / 2, 400 / 640.0, 0.01);
  EXPECT_FALSE(detector.Look(GreyPicture(), 3, std::nullopt).sighting->seen);
}

TEST_F(NetDetector, OfTwoLabelsThatAreNearlyAsConfidentSaysNone) {
  auto made = MakeNetDetector(With(CellsModel(Says::kRows)));
  ASSERT_TRUE(made) << made.error().message;
  const cv::Mat both = WithThing(kPureRed, 0, 80, WithThing(kPureGreen, 480, 80));
  for (int i = 1; i <= 3; ++i) {
    const CourseSight sight = made.value()->Look(both, i, std::nullopt);
    EXPECT_TRUE(sight.sighting->seen);
    EXPECT_EQ(sight.text, std::nullopt);
    EXPECT_EQ(sight.sighting->text, "");
  }
}

TEST_F(NetDetector, MeasuresTheDistanceByTheHeightOfTheThing) {
  NetParameters parameters = With(CellsModel(Says::kRows));
  parameters.height_m = 0.32;
  auto made = MakeNetDetector(parameters);
  ASSERT_TRUE(made) << made.error().message;
  const cv::Mat cut = WithThing(kPureRed, 160, 80);
  cv::Mat whole;
  cv::copyMakeBorder(cut, whole, 80, 80, 0, 0, cv::BORDER_CONSTANT, cv::Scalar::all(114));
  const CourseSight sight = made.value()->Look(whole, 1, PinholeOf(M_PI / 2, 640, 640));
  EXPECT_NEAR(sight.sighting->distance_m, 0.32, 0.01) << "320 px high at a focal length of 320 px";
  const CourseSight near = made.value()->Look(cut, 2, PinholeOf(M_PI / 2, 640, 480));
  EXPECT_TRUE(std::isnan(near.sighting->distance_m)) << "the picture's edge cuts it";
}

TEST_F(NetDetector, ThatYieldsNumbersThatAreNotFiniteIsInDoubt) {
  const float spoilt = std::numeric_limits<float>::quiet_NaN();
  auto made = MakeNetDetector(With(CellsModel(Says::kRows, spoilt)));
  ASSERT_TRUE(made) << made.error().message;
  const CourseSight sight = made.value()->Look(WithThing(kPureRed, 160, 80), 1, std::nullopt);
  EXPECT_EQ(sight.sighting, std::nullopt) << "it would say that nothing is there";
  EXPECT_EQ(sight.text, std::nullopt);
  EXPECT_EQ(sight.doubt, "the network yields numbers that are not finite");
}

TEST_F(NetDetector, ThatIsSlowIsInDoubtAndSaysItsLabelAgainAfterRepeats) {
  NetParameters parameters = With(CellsModel(Says::kRows));
  Duration now{}, took = Milliseconds(10);
  auto made = MakeNetDetector(parameters, [&] { return now += took; });
  ASSERT_TRUE(made) << made.error().message;
  CourseDetector& detector = *made.value();
  const cv::Mat bgr = WithThing(kPureRed, 160, 80);
  detector.Look(bgr, 1, std::nullopt);
  EXPECT_EQ(detector.Look(bgr, 2, std::nullopt).text, "red");
  took = Milliseconds(700);
  const CourseSight slow = detector.Look(bgr, 3, std::nullopt);
  EXPECT_EQ(slow.sighting, std::nullopt);
  EXPECT_EQ(slow.doubt, "the network took 700 ms for a picture: what it shows is old");
  took = Milliseconds(10);
  EXPECT_EQ(detector.Look(bgr, 4, std::nullopt).text, std::nullopt);
  EXPECT_EQ(detector.Look(bgr, 5, std::nullopt).text, "red");
}

TEST_F(NetDetector, WhoseModelCannotWorkIsNotLoaded) {
  NetParameters parameters = With("");
  EXPECT_EQ(LoadError(parameters), "this is no ONNX model");
  EXPECT_THAT(LoadError(With("no model at all")), HasSubstr("no ONNX model that OpenCV can load"));
  const std::string whole = CellsModel(Says::kRows);
  EXPECT_NE(LoadError(With(whole.substr(0, whole.size() / 2))), "");
  EXPECT_EQ(LoadError(With(CellsModel(Says::kTwoOutputs))),
            "the network has 2 outputs, where one is expected");
  EXPECT_EQ(LoadError(With(CellsModel(Says::kCells))),
            "the network's output of 1 x 6 x 4 x 4 is of no known layout; with so many labels, 2, "
            "expected 1 x N x 7, 1 x 6 x N or 1 x 1 x N x 7");
  parameters = With(CellsModel(Says::kRows));
  parameters.labels.emplace_back("blue");
  EXPECT_THAT(LoadError(parameters), HasSubstr("output of 1 x 16 x 7 is of no known layout; with "
                                               "so many labels, 3, expected 1 x N x 8"));
  parameters = With(CellsModel(Says::kRows));
  parameters.width_px = 64;
  EXPECT_THAT(LoadError(parameters), HasSubstr("the network takes no picture of 64 x 32 pixels"));
  std::filesystem::remove(parameters.model);
  EXPECT_EQ(LoadError(parameters), "there is no such file");
  parameters.model = folder_.path();
  EXPECT_EQ(LoadError(parameters), "there is no such file");
}

TEST_F(NetDetector, WhoseModelCannotWorkIsRefusedWithItsPlaceInTheFile) {
  With(CellsModel(Says::kRows));
  const std::string size = "width_px = 32\nheight_px = 32\n";
  EXPECT_THAT(Said("model = \"things.onnx\"\nlabels = [\"red\", \"green\"]\n" + size), IsEmpty());
  EXPECT_THAT(
      Said("model = \"none.onnx\"\nlabels = [\"red\", \"green\"]\n" + size),
      ElementsAre(::testing::AllOf(HasSubstr("course.toml:5:9: error: detectors.things.parameters."
                                             "model: " +
                                             folder_.path()),
                                   HasSubstr("none.onnx: there is no such file"))));
  EXPECT_THAT(Said("model = \"things.onnx\"\nlabels = [\"red\"]\n" + size),
              ElementsAre(HasSubstr("of no known layout")));
  EXPECT_THAT(Said("mean = [1, 2]\nleast_confidence = 2\n"),
              ElementsAre(HasSubstr("course.toml:4:1: error: detectors.things.parameters: the key "
                                    "\"model\" is missing"),
                          HasSubstr("the key \"labels\" is missing"),
                          HasSubstr("course.toml:5:8: error: detectors.things.parameters.mean: "
                                    "expected three integers"),
                          HasSubstr("least_confidence: expected a number from 0.01 to 1")));
}

TEST(NetOutput, LayoutIsKnownByItsShapeAndTheLabels) {
  EXPECT_EQ(LayoutOf({1, 25200, 85}, 80), NetLayout::kRows);
  EXPECT_EQ(LayoutOf({1, 84, 8400}, 80), NetLayout::kColumns);
  EXPECT_EQ(LayoutOf({1, 1, 100, 7}, 80), NetLayout::kShares);
  EXPECT_EQ(LayoutOf({1, 25200, 85}, 79), std::nullopt);
  EXPECT_EQ(LayoutOf({2, 84, 8400}, 80), std::nullopt) << "of two pictures";
  EXPECT_EQ(LayoutOf({1, 6, 7}, 2), std::nullopt) << "six rows, or seven columns";
  EXPECT_EQ(LayoutOf({1, 1000}, 1000), std::nullopt) << "a label of the whole picture";
  EXPECT_EQ(LayoutOf({}, 2), std::nullopt);
}

TEST(NetOutput, OfSharesIsReadWithItsBoxesOnThePicture) {
  NetParameters parameters;
  parameters.labels = {"cup", "bottle"};
  parameters.width_px = parameters.height_px = 320;
  // A bottle, the same again less surely, a cup there, one that is unsure, and an unknown label.
  std::vector<float> rows{0, 1, 0.9F, 0.25F, 0.5F,  0.5F, 0.75F,  //
                          0, 1, 0.7F, 0.25F, 0.5F,  0.5F, 0.7F,   //
                          0, 0, 0.8F, 0.25F, 0.5F,  0.5F, 0.75F,  //
                          0, 0, 0.3F, 0,     0.25F, 0.1F, 0.5F,   //
                          0, 7, 0.9F, 0,     0.25F, 0.1F, 0.5F};
  const std::vector<int> shape{1, 1, 5, 7};
  const cv::Mat output(4, shape.data(), CV_32F, rows.data());
  const NetPlace place = PlaceInInput({640, 480}, parameters);
  const auto look = ReadNetOutput(output, NetLayout::kShares, place, parameters);
  ASSERT_EQ(look.boxes.size(), 2U);
  EXPECT_EQ(look.boxes[0].label, 1U);
  EXPECT_EQ(look.boxes[1].label, 0U);
  // 640 x 480 is half as large in the input, between bars of 40 pixels.
  EXPECT_NEAR(look.boxes[0].box.x, 160, 1e-3);
  EXPECT_NEAR(look.boxes[0].box.y, 240, 1e-3);
  EXPECT_NEAR(look.boxes[0].box.width, 160, 1e-3);
  EXPECT_NEAR(look.boxes[0].box.height, 160, 1e-3);
}

}  // namespace musher::vision::net_detector_test
