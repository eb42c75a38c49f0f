#pragma once
// Whether the signs of a line can be the word that a text reader has read. Pure.
//
// A reader of text takes an 8 for a B and, under a lamp, a 1 for a 2: it prefers what it has
// learned to what it sees. The shapes say more: a 1 has a stem, a 2 a stroke that goes to the left,
// and the left side of a B is straight. A line with more or fewer signs than the word has letters
// is another word.
//
// Threads: any.

#include <opencv2/core.hpp>
#include <string>

namespace musher::vision {

// `letters`: CV_8UC1, ink 0 on 255, one line of `letter_px` high letters with a rim. Words with
// signs beyond ASCII always fit.
bool GlyphsFit(const cv::Mat& letters, double letter_px, const std::string& word);

}  // namespace musher::vision
