#include "musher/behavior/tree/xml/places.hpp"

#include <algorithm>

namespace musher::tree {
namespace {

class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  Places Run() && {
    while ((at_ = std::min(text_.find('<', at_), text_.size())) < text_.size()) {
      const char next = at_ + 1 < text_.size() ? text_[at_ + 1] : ' ';
      if (next == '!') {
        if (SkipTo("<!--", "-->") || SkipTo("<![CDATA[", "]]>") || SkipTo("<!", ">")) continue;
      } else if (next == '?') {
        if (SkipTo("<?", "?>")) continue;
      } else if (next == '/') {
        if (SkipTo("</", ">")) continue;
      }
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
    places_.elements.push_back(
        {static_cast<std::uint32_t>(at_++), static_cast<std::uint32_t>(places_.attributes.size())});
    SkipName();
    while (true) {
      SkipSpaces();
      if (at_ >= text_.size()) return;
      if (text_[at_] == '>' || text_[at_] == '/') {
        ++at_;
        return;
      }
      AttributePlace attribute{.name_at = static_cast<std::uint32_t>(at_)};
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
      places_.attributes.push_back(attribute);
      at_ = std::min(text_.find(quote, at_), text_.size());
      if (at_ < text_.size()) ++at_;
    }
  }

  const std::string_view text_;
  std::size_t at_ = 0;
  Places places_;
};

}  // namespace

Places FindPlaces(std::string_view text) {
  return Scanner(text).Run();
}

}  // namespace musher::tree
