#include "musher/behavior/tree/xml/places.hpp"

#include <algorithm>

namespace musher::tree {
namespace {

class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  std::vector<ElementPlace> Run() && {
    while ((at_ = std::min(text_.find('<', at_), text_.size())) < text_.size()) {
      if (SkipTo("<!--", "-->") || SkipTo("<![CDATA[", "]]>") || SkipTo("<?", "?>")) continue;
      if (SkipTo("<!", ">") || SkipTo("</", ">")) continue;
      ScanElement();
    }
    return std::move(places_);
  }

 private:
  static bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  bool SkipTo(std::string_view begin, std::string_view end) {
    if (!text_.substr(at_).starts_with(begin)) return false;
    const std::size_t found = text_.find(end, at_ + begin.size());
    at_ = found == std::string_view::npos ? text_.size() : found + end.size();
    return true;
  }
  void SkipSpaces() {
    while (at_ < text_.size() && IsSpace(text_[at_])) ++at_;
  }
  void SkipName() {
    while (at_ < text_.size() && !IsSpace(text_[at_]) && text_[at_] != '=' && text_[at_] != '>' &&
           text_[at_] != '/') {
      ++at_;
    }
  }

  void ScanElement() {
    ElementPlace& place = places_.emplace_back();
    place.at = static_cast<std::uint32_t>(at_++);
    SkipName();
    while (true) {
      SkipSpaces();
      if (at_ >= text_.size()) return;
      if (text_[at_] == '>' || text_[at_] == '/') {
        ++at_;
        return;
      }
      ElementPlace::Attribute attribute{.name_at = static_cast<std::uint32_t>(at_)};
      const std::size_t begin = at_;
      SkipName();
      SkipSpaces();
      if (at_ >= text_.size() || text_[at_] != '=' || at_ == begin) {
        at_ = std::max(at_, begin + 1);
        return;
      }
      ++at_;
      SkipSpaces();
      if (at_ >= text_.size()) return;
      const char quote = text_[at_++];
      attribute.value_at = static_cast<std::uint32_t>(at_);
      place.attributes.push_back(attribute);
      at_ = std::min(text_.find(quote, at_), text_.size());
      if (at_ < text_.size()) ++at_;
    }
  }

  const std::string_view text_;
  std::size_t at_ = 0;
  std::vector<ElementPlace> places_;
};

}  // namespace

std::vector<ElementPlace> FindPlaces(std::string_view text) {
  return Scanner(text).Run();
}

}  // namespace musher::tree
