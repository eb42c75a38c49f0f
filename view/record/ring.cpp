#include "musher/view/record/ring.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "musher/base/date_text.hpp"

namespace musher::view {

std::vector<RingAction> Ring::At(Time now) {
  std::vector<RingAction> actions;
  const bool kept = trouble_ && now >= trouble_->keep_until;
  const bool full = segments_.empty() || now - segments_.back().begin >= options_.segment;
  if (kept || full) {
    if (!segments_.empty()) segments_.back().end = now;
    actions.emplace_back(BeginSegment{next_});
  }
  if (kept) {
    actions.emplace_back(Keep());
    trouble_.reset();
  }
  if (kept || full) segments_.push_back({next_++, now, std::nullopt});
  const Time oldest = OldestNeeded(now);
  while (segments_.size() > 1 && segments_.front().end <= oldest) {
    actions.emplace_back(DeleteSegment{segments_.front().number});
    segments_.pop_front();
  }
  return actions;
}

void Ring::OnTrouble(const std::string& reason, Time now, std::int64_t wall_ns) {
  const Time until = now + options_.after;
  if (!trouble_) {
    trouble_ = Trouble{reason, wall_ns, now, until};
    return;
  }
  // Trouble without an end is kept in files of at most twice the ring.
  const Time limit = trouble_->first + options_.length;
  trouble_->keep_until = std::max(trouble_->keep_until, std::min(until, limit));
}

std::vector<RingAction> Ring::End(Time now) {
  if (!trouble_) return {};
  if (!segments_.empty()) segments_.back().end = now;
  const KeepSegments keep = Keep();
  trouble_.reset();
  return {keep};
}

KeepSegments Ring::Keep() const {
  KeepSegments keep{{}, trouble_->reason, trouble_->wall_ns};
  const Time from = trouble_->first - options_.length;
  for (const Segment& segment : segments_) {
    if (segment.end > from) keep.numbers.push_back(segment.number);
  }
  return keep;
}

Time Ring::OldestNeeded(Time now) const {
  return (trouble_ ? std::min(trouble_->first, now) : now) - options_.length;
}

std::string KeptName(std::int64_t trouble_ns, const std::string& reason) {
  std::string name = FormatUtc(WholeSeconds(trouble_ns)) + "_" + reason.substr(0, 80);
  for (char& c : name) {  // the colons of the time, too
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_') c = '-';
  }
  return name + ".mcap";
}

bool IsKeptName(std::string_view name) {
  constexpr std::string_view kForm = "0000-00-00T00-00-00Z_";
  constexpr std::string_view kEnd = ".mcap";
  if (name.size() <= kForm.size() + kEnd.size() || !name.ends_with(kEnd)) return false;
  for (std::size_t i = 0; i < kForm.size(); ++i) {
    const bool digit = name[i] >= '0' && name[i] <= '9';
    if (kForm[i] == '0' ? !digit : name[i] != kForm[i]) return false;
  }
  return true;
}

std::string SegmentName(std::uint64_t number) {
  std::string digits = std::to_string(number);
  digits.insert(0, 8 - std::min<std::size_t>(digits.size(), 8), '0');
  return digits + ".mcap";
}

std::uint64_t SegmentNumber(std::string_view name) {
  std::uint64_t number = 0;
  std::from_chars(name.data(), name.data() + name.size(), number);
  return SegmentName(number) == name ? number : 0;
}

std::vector<std::string> OldestBeyond(std::vector<std::string> names, std::size_t max) {
  std::sort(names.begin(), names.end());
  names.resize(names.size() > max ? names.size() - max : 0);
  return names;
}

}  // namespace musher::view
