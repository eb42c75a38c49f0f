#pragma once
// Photographs that Debian packages have: what is behind the things, and what floors are made of, in
// pictures that no program has painted. A package that is not installed leaves its photographs out;
// MUSHER_PHOTOGRAPHS=FOLDER is where packages were unpacked instead of being installed.
//
// Each scene is of one of two halves. Rules of a detector are made while looking at pictures of the
// one half, also at parts of them; those of the held half only count, when the rules are done.
//
// Threads: one at a time.

#include <cstddef>
#include <opencv2/core.hpp>
#include <ostream>
#include <string>
#include <vector>

namespace musher::vision::photographs {

struct Photograph {
  std::string name;             // of its file, without the folder
  cv::Rect2d part{0, 0, 1, 1};  // of it that is used, as shares
  double wide_m = 1;            // of a floor: how wide that part is
  cv::Scalar tint{1, 1, 1};     // of a grey photograph: blue, green, red
};

enum class Half { kLookedAt, kHeld };

struct Package {
  std::string name;    // of Debian
  std::string folder;  // of its photographs
  std::vector<Photograph> scenes;
  std::vector<Photograph> floors;
  bool is_held = false;  // all of its scenes; else every second four
};

inline void PrintTo(const Package& package, std::ostream* out) {
  *out << package.name;
}

const std::vector<Package>& Packages();

// Whether its folder is there.
bool IsInstalled(const Package& package);

// Of the scene at that place of the package.
Half HalfOf(const Package& package, std::size_t scene);

// Four corners of the scene, in which what it shows is larger.
std::vector<Photograph> PartsOf(const Photograph& scene);

// In linear light from 0 to 1, CV_32FC3, at most 1024 pixels wide. Its test fails where the package
// has no such photograph.
cv::Mat LinearOf(const Package& package, const Photograph& photograph);

}  // namespace musher::vision::photographs
