#include "musher/modules/skills/skills/points_text.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <functional>

namespace musher::skills {
namespace {

constexpr std::size_t kMostPointsInText = 10'000;

// Reads from the left; the first error stays.
class ListReader {
 public:
  ListReader(const std::string& name, std::string_view text) : name_(name), text_(text) {}

  // "[", items with commas between, "]". False: an error.
  bool List(const std::function<bool()>& item) {
    if (!Take('[')) return Expect("'['");
    if (Take(']')) return true;
    for (;;) {
      if (!item()) return false;
      if (Take(']')) return true;
      if (!Take(',')) return Expect("',' or ']'");
    }
  }
  bool Number(double& number) {
    SkipSpace();
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), number);
    if (error != std::errc() || !std::isfinite(number)) return Expect("a finite number");
    at_ += static_cast<std::size_t>(end - begin);
    return true;
  }
  bool Place(Points& points) {
    const std::size_t begin = at_;
    std::vector<double> numbers;
    const auto number = [&] {
      numbers.push_back(0);
      return numbers.size() <= 3 ? Number(numbers.back()) : Expect("2 or 3 numbers of a place");
    };
    if (!List(number)) return false;
    if (numbers.size() < 2) {
      at_ = begin;
      return Expect("2 or 3 numbers of a place");
    }
    if (++count_ > kMostPointsInText) return Expect("at most 10000 places");
    points.push_back({numbers[0], numbers[1], numbers.size() == 3 ? numbers[2] : 0});
    return true;
  }
  bool Places(Points& points) {
    return List([&] { return Place(points); });
  }
  bool AtEnd() {
    SkipSpace();
    return at_ == text_.size();
  }
  bool Expect(const std::string& what) {
    if (error_.empty()) {
      error_ = fmt::format("{}, character {}: expected {}", name_, at_ + 1, what);
    }
    return false;
  }
  Error error() const { return {kCodeParametersInvalid, error_}; }

 private:
  void SkipSpace() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) < 4) ++at_;
  }
  bool Take(char expected) {
    SkipSpace();
    if (at_ >= text_.size() || text_[at_] != expected) return false;
    ++at_;
    return true;
  }

  const std::string& name_;
  const std::string_view text_;
  std::size_t at_ = 0;
  std::size_t count_ = 0;
  std::string error_;
};

}  // namespace

Result<Points> ParsePoints(const std::string& name, std::string_view text) {
  ListReader reader(name, text);
  Points points;
  if (reader.AtEnd()) return points;
  if (!reader.Places(points)) return reader.error();
  if (reader.AtEnd()) return points;
  reader.Expect("the end of the text");
  return reader.error();
}

bool HasLists(std::string_view text) {
  int open = 0;
  for (const char letter : text) {
    if (letter == '[') ++open;
    const bool goes_on = letter == '[' || std::string_view(" \t\r\n").find(letter) < 4;
    if (open == 3 || !goes_on) break;
  }
  return open == 3;
}

std::string ListsText(const std::vector<Points>& lists) {
  std::string text;
  for (const Points& list : lists) {
    text += text.empty() ? "[" : ", [";
    for (std::size_t i = 0; i < list.size(); ++i) {
      text += fmt::format("{}[{:.2f}, {:.2f}]", i == 0 ? "" : ", ", list[i].x_m, list[i].y_m);
    }
    text += "]";
  }
  return "[" + text + "]";
}

Result<std::vector<Points>> ParseLists(const std::string& name, std::string_view text) {
  ListReader reader(name, text);
  std::vector<Points> lists;
  if (reader.AtEnd()) return lists;
  const auto list = [&] {
    lists.emplace_back();
    return reader.Places(lists.back());
  };
  if (!reader.List(list)) return reader.error();
  if (reader.AtEnd()) return lists;
  reader.Expect("the end of the text");
  return reader.error();
}

}  // namespace musher::skills
