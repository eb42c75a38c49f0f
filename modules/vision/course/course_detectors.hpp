#pragma once
// Makes the detectors of a course. What each finds, its units, and where its numbers come from are
// in the header of its parameters.
//
//   detector   text topic                                    sighting
//   lines      -                                             - (YellowLines)
//   arrow      "left", "right": at first and on a change     text = the direction
//   barrier    "1.24" (m) while it is seen                   phase "", "seen", then "top"
//   marker     "1.24" (m) while it is tracked and seen       phase "searching", "tracking",
//   light      the same                                      "disappeared", "hidden"
//   qr         a word, in each picture in which it is read   text = the word, or what else it says
//   aruco      the word of a marker, in each picture         text = the word
//   net        the label of a thing, in each picture         text = the label
//
// Threads: one call at a time for each detector.

#include <functional>
#include <memory>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/modules/vision/course/arrow_finder.hpp"
#include "musher/modules/vision/course/aruco_finder.hpp"
#include "musher/modules/vision/course/barrier_finder.hpp"
#include "musher/modules/vision/course/course_detector.hpp"
#include "musher/modules/vision/course/lines_finder.hpp"
#include "musher/modules/vision/course/marker_finder.hpp"
#include "musher/modules/vision/course/net_finder.hpp"
#include "musher/modules/vision/course/qr_finder.hpp"

namespace musher::vision {

std::unique_ptr<CourseDetector> MakeLinesDetector(const LinesParameters& parameters);
std::unique_ptr<CourseDetector> MakeArrowDetector(const ArrowParameters& parameters);
std::unique_ptr<CourseDetector> MakeBarrierDetector(const BarrierParameters& parameters);

std::unique_ptr<CourseDetector> MakeArucoDetector(const ArucoParameters& parameters);

// By the time since any point, without jumps.
using SteadyClock = std::function<Duration()>;
Duration SteadyNow();

// Loads the model. The Error names its file.
Result<std::unique_ptr<CourseDetector>> MakeNetDetector(const NetParameters& parameters,
                                                        SteadyClock now = SteadyNow);

// Also makes a detector of lights, of LightParameters().
std::unique_ptr<CourseDetector> MakeMarkerDetector(const MarkerParameters& parameters);

// Loads Tesseract's model in the first picture in which letters are to be read; that Look() throws
// a std::runtime_error with the package to install if it cannot. CheckLetters() does so early.
std::unique_ptr<CourseDetector> MakeQrDetector(const QrParameters& parameters);

// Whether the letters can be read as the parameters say; always when they are not to be read.
Result<> CheckLetters(const QrParameters& parameters);

}  // namespace musher::vision
