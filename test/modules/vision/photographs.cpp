#include "musher/test/modules/vision/photographs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace musher::vision::photographs {
namespace {

std::string PathOf(const Package& package) {
  const char* unpacked = std::getenv("MUSHER_PHOTOGRAPHS");
  return (unpacked == nullptr ? std::string() : std::string(unpacked)) + package.folder;
}

std::vector<Photograph> Named(const std::vector<std::string>& names) {
  std::vector<Photograph> photographs;
  for (const std::string& name : names) photographs.push_back({name});
  return photographs;
}

}  // namespace

const std::vector<Package>& Packages() {
  const cv::Rect2d all(0, 0, 1, 1);
  const cv::Scalar stone(0.85, 0.95, 1), grass(0.35, 1, 0.55);
  static const std::vector<Package> packages = {
      {"opencv-doc",
       "/usr/share/doc/opencv-doc/examples/data",
       Named({"aloeL.jpg", "basketball1.png", "board.jpg", "box_in_scene.png", "building.jpg",
              "butterfly.jpg", "fruits.jpg", "graf1.png", "home.jpg", "leuvenA.jpg", "messi5.jpg",
              "rubberwhale1.png", "smarties.png", "squirrel_cls.jpg", "stuff.jpg", "sudoku.png"}),
       {{"stuff.jpg", {0.02, 0.02, 0.3, 0.4}, 1.2},
        {"leuvenA.jpg", {0.35, 0.75, 0.3, 0.24}, 1.5},
        {"messi5.jpg", {0.02, 0.8, 0.5, 0.18}, 2}}},
      {"python3-skimage",
       "/usr/lib/python3/dist-packages/skimage/data",
       Named({"astronaut.png", "camera.png", "chelsea.png", "coffee.png", "motorcycle_left.png",
              "page.png", "rocket.jpg"}),
       {{"brick.png", all, 1.2, stone},
        {"gravel.png", all, 1, stone},
        {"grass.png", all, 1.5, grass},
        {"motorcycle_left.png", {0.02, 0.86, 0.3, 0.13}, 1},
        {"coffee.png", {0, 0.02, 0.3, 0.45}, 0.8}}},
      {"python3-sklearn",
       "/usr/lib/python3/dist-packages/sklearn/datasets/images",
       Named({"china.jpg", "flower.jpg"}),
       {}},
      {"mate-backgrounds",
       "/usr/share/backgrounds/mate/nature",
       Named({"Blinds.jpg", "Dune.jpg", "FreshFlower.jpg", "Garden.jpg", "GreenMeadow.jpg",
              "LadyBird.jpg", "RainDrops.jpg", "Storm.jpg", "YellowFlower.jpg"}),
       {{"Wood.jpg", {0, 0.3, 1, 0.6}, 0.6}, {"GreenMeadow.jpg", {0, 0.1, 1, 0.7}, 1}}},
      {"lomiri-wallpapers-16.04",
       "/usr/share/backgrounds",
       Named({"Bridge_by_Sander_Klootwijk.jpg", "Dragonfly_by_Bolly.jpg",
              "Picture_0B_by_freespace.jpg", "Picture_1A_by_freespace.jpg",
              "Wine_by_Jakkub_Mede.jpg", "aitzgorri_by_Aitzol_Berasategi.jpg",
              "analogpattern_by_Peter_Nerlich.jpg", "free_by_Peter_Nerlich.jpg",
              "friends_by_Aitzol_Berasategi.jpg", "greentock_by_Peter_Nerlich.jpg",
              "life_by_Aitzol_Berasategi.jpg", "picosdeeuropa_by_Aitzol_Berasategi.jpg",
              "seeding_by_Clements_Engelhardt.jpg", "sunset_by_Aitzol_Berasategi.jpg",
              "umang_by_Abhishek_Mudgal.jpg"}),
       {},
       true},
      {"ukui-wallpapers",
       "/usr/share/backgrounds",
       Named({"2004default.jpg", "calla.png", "city.png", "desert.png", "firstgeneration.jpg",
              "fluent-color.png", "focal-ubuntukylin.png", "goldfish.png", "rhythm.jpg",
              "rollpaper.png", "string.jpg", "the-mouse.jpg"}),
       {},
       true}};
  return packages;
}

// Two packages have one folder.
bool IsInstalled(const Package& package) {
  const std::vector<Photograph>& some = package.scenes.empty() ? package.floors : package.scenes;
  return std::filesystem::exists(PathOf(package) + "/" + some.front().name);
}

Half HalfOf(const Package& package, std::size_t scene) {
  constexpr std::size_t kLights = 4;  // in which the scenes are taken in turn
  return package.is_held || (scene / kLights) % 2 == 1 ? Half::kHeld : Half::kLookedAt;
}

std::vector<Photograph> PartsOf(const Photograph& scene) {
  constexpr double kPart = 0.6;
  std::vector<Photograph> parts;
  for (const double left : {0.0, 1 - kPart}) {
    for (const double top : {0.0, 1 - kPart}) {
      parts.push_back(scene);
      parts.back().part = {left, top, kPart, kPart};
    }
  }
  return parts;
}

cv::Mat LinearOf(const Package& package, const Photograph& photograph) {
  constexpr int kWidest = 1024;
  const std::string path = PathOf(package) + "/" + photograph.name;
  cv::Mat bgr = cv::imread(path, cv::IMREAD_COLOR);
  EXPECT_FALSE(bgr.empty()) << path;
  if (bgr.empty()) return cv::Mat(1, 1, CV_32FC3, cv::Scalar());
  const cv::Rect2d& part = photograph.part;
  bgr = bgr(cv::Rect(cvRound(part.x * bgr.cols), cvRound(part.y * bgr.rows),
                     std::max(1, cvRound(part.width * bgr.cols)),
                     std::max(1, cvRound(part.height * bgr.rows))) &
            cv::Rect({0, 0}, bgr.size()));
  const double smaller = std::min(1.0, double(kWidest) / bgr.cols);
  if (smaller < 1) cv::resize(bgr, bgr, {}, smaller, smaller, cv::INTER_AREA);
  cv::Mat linear;
  bgr.convertTo(linear, CV_32FC3, 1 / 255.0);
  cv::pow(linear, 2.2, linear);
  cv::multiply(linear, photograph.tint, linear);
  return linear;
}

}  // namespace musher::vision::photographs
