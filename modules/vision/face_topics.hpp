#pragma once
// Faces on the network: hears pictures while it looks, gives them to a looker, and tells what they
// show. Runs on any transport.
//
// target and too_close are published with a picture that shows them: who hears them judges by their
// age. A new one says nothing of too_close until it has seen somebody or looked for `hold`: one who
// fills the picture is not seen, and may have been too close before. While it should look and no
// picture comes, faces_json says an empty list again and again, and too_close says true if it was:
// nobody has been seen to leave.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/vision/face_watch.hpp"
#include "musher/modules/vision/looker.hpp"
#include "musher/modules/vision/picture.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher::vision {

struct Dependencies {
  transport::Node& node;
  transport::Clock& clock;  // of the module's behaviour
  std::string name_space;
  std::function<std::int64_t()> stamp_ns;  // now, as the stamps of pictures have it
  std::function<void(const Error&)> log;   // what is wrong; code 0: that it is well
  Looker& looker;
};

class FaceTopics {
 public:
  static Result<std::unique_ptr<FaceTopics>> Make(const Dependencies& around,
                                                  const VisionConfig& config);

  // The robot is in a state in which it looks; a self-check goes on, which tells nobody what it
  // sees. Fails when the pictures cannot be heard.
  Result<> SetOn(bool on);
  Result<> SetChecked(bool checked);

  // Has a picture been looked at since it was wanted, and is all well? Fails with why not.
  Result<> Check() const;

  // Of the looker.
  void OnResult(const LookResult& result);
  void OnLeftOut() { ++left_out_; }

  bool looks() const { return pictures_ != nullptr; }
  std::uint64_t left_out() const { return left_out_; }  // for a newer one
  std::uint64_t looked_at() const { return looked_at_; }

 private:
  // What is said once, and once when it is over; again only after a quiet minute.
  struct Trouble {
    std::optional<Error> error;
    bool told = false;
    std::optional<Time> told_at;
  };

  FaceTopics(const Dependencies& around, VisionConfig config);
  Result<> MakePublishers();
  Result<> Reconsider();
  Result<> Hear();
  void Leave();
  void OnPicture(msg::Image picture);
  void OnInfo(const msg::CameraInfo& info);
  void OnJump();
  void OnSilence();
  void AwaitNext();
  void NoteGap(Duration gap);
  void Tell(const Sight& sight);
  void TellNobody();
  std::optional<Lens> LensFor(const LookResult& result) const;
  void Set(Trouble& trouble, const Result<>& result, const std::string& well) const;
  std::string PictureTopic() const {
    return transport::ResolveName(around_.name_space, config_.picture);
  }

  const Dependencies around_;
  const VisionConfig config_;
  bool on_ = false;
  bool checked_ = false;
  StampGate gate_;
  FaceWatch watch_;
  std::optional<Lens> lens_;  // of the CameraInfo
  std::uint64_t looked_at_ = 0;
  std::uint64_t left_out_ = 0;
  bool too_close_now_ = false;  // by the last picture that was looked at
  bool seen_ = false;           // a picture was looked at since pictures are heard
  std::int64_t newest_ns_ = 0;  // stamp of the last picture that was given to the looker
  std::int64_t looked_ns_ = 0;  // stamp of the last picture that was looked at
  Trouble picture_trouble_;
  Trouble info_trouble_;
  Trouble detector_trouble_;
  Trouble rarity_;
  int rare_ = 0;  // pictures in a row that were long after the one before
  Trouble silence_;
  std::optional<Time> jump_told_;
  std::optional<Time> asked_;  // the looker, and no result has come since
  std::unique_ptr<transport::Publisher<msg::PointStamped>> target_;
  std::unique_ptr<transport::Publisher<msg::Bool>> too_close_;
  std::unique_ptr<transport::Publisher<msg::String>> faces_;
  transport::LoopHandlePtr silence_timer_;
  std::unique_ptr<transport::Subscription> infos_;
  std::unique_ptr<transport::Subscription> pictures_;
};

}  // namespace musher::vision
