#pragma once
// An MCAP file to be played.

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "musher/view/mcap/scan.hpp"
#include "musher/view/record/player.hpp"
#include "musher/view/topics/topic_choice.hpp"

namespace musher::view {

class McapSource : public PlaySource {
 public:
  // `start`: from this far into the recording. Latched samples from before are played at the
  // beginning. `machine`: also topics that a robot would obey.
  static Result<std::unique_ptr<McapSource>> Open(const std::string& path, TopicChoice choice,
                                                  Duration start, bool machine);

  const std::vector<PlayedChannel>& channels() const override { return channels_; }
  Result<std::optional<PlayedMessage>> Next() override;
  Result<> Rewind() override;

  // Topics that are not played, as ROS 2 names them: those of a machine; and those without a type.
  const std::set<std::string>& of_machine() const { return of_machine_; }
  const std::set<std::string>& untyped() const { return untyped_; }
  const TopicChoice& choice() const { return choice_; }
  const std::string& damage() const { return scan_->damage(); }

 private:
  McapSource(std::unique_ptr<mcap::Scan> scan, TopicChoice choice)
      : scan_(std::move(scan)), choice_(std::move(choice)) {}

  void Choose(bool machine);
  void Order(Duration start);

  struct Planned {
    std::size_t index;  // of the scan's messages
    std::int64_t log_ns;
  };

  std::unique_ptr<mcap::Scan> scan_;
  TopicChoice choice_;
  std::vector<PlayedChannel> channels_;
  std::map<std::uint16_t, std::size_t> played_;  // by the file's channel
  std::set<std::string> of_machine_;
  std::set<std::string> untyped_;
  std::vector<Planned> plan_;
  std::size_t next_ = 0;
};

}  // namespace musher::view
