#include "musher/view/record/ring.hpp"

#include <algorithm>
#include <cctype>

#include "musher/base/date_text.hpp"

namespace musher::view {

std::vector<RingAction> Ring::At(std::int64_t now_ns) {
  std::vector<RingAction> actions;
  const bool kept = trouble_ && now_ns >= trouble_->keep_until_ns;
  const bool full =
      segments_.empty() || now_ns - segments_.back().begin_ns >= options_.segment.count();
  if (kept || full) {
    if (!segments_.empty()) segments_.back().end_ns = now_ns;
    actions.emplace_back(BeginSegment{next_});
  }
  if (kept) {
    actions.emplace_back(Keep());
    trouble_.reset();
  }
  if (kept || full) segments_.push_back({next_++, now_ns, 0});
  const std::int64_t oldest = OldestNeeded(now_ns);
  while (segments_.size() > 1 && segments_.front().end_ns <= oldest) {
    actions.emplace_back(DeleteSegment{segments_.front().number});
    segments_.pop_front();
  }
  return actions;
}

void Ring::OnTrouble(const std::string& reason, std::int64_t now_ns) {
  const std::int64_t until = now_ns + options_.after.count();
  if (!trouble_) {
    trouble_ = Trouble{reason, now_ns, until};
    return;
  }
  // Trouble without an end is kept in files of at most twice the ring.
  const std::int64_t limit = trouble_->first_ns + options_.length.count();
  trouble_->keep_until_ns = std::max(trouble_->keep_until_ns, std::min(until, limit));
}

std::vector<RingAction> Ring::End(std::int64_t now_ns) {
  if (!trouble_) return {};
  if (!segments_.empty()) segments_.back().end_ns = now_ns;
  const KeepSegments keep = Keep();
  trouble_.reset();
  return {keep};
}

KeepSegments Ring::Keep() const {
  KeepSegments keep{{}, trouble_->reason, trouble_->first_ns};
  const std::int64_t from = trouble_->first_ns - options_.length.count();
  for (const Segment& segment : segments_) {
    if (segment.end_ns > from) keep.numbers.push_back(segment.number);
  }
  return keep;
}

std::int64_t Ring::OldestNeeded(std::int64_t now_ns) const {
  const std::int64_t from = trouble_ ? std::min(trouble_->first_ns, now_ns) : now_ns;
  return from - options_.length.count();
}

std::string KeptName(std::int64_t trouble_ns, const std::string& reason) {
  std::string name = FormatUtc(WholeSeconds(trouble_ns)) + "_" + reason.substr(0, 80);
  for (char& c : name) {  // the colons of the time, too
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_') c = '-';
  }
  return name + ".mcap";
}

std::vector<std::string> OldestBeyond(std::vector<std::string> names, std::size_t max) {
  std::sort(names.begin(), names.end());
  names.resize(names.size() > max ? names.size() - max : 0);
  return names;
}

}  // namespace musher::view
