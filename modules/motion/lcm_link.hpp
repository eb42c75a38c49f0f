#pragma once
// What a process sends to a motion board on LCM, and what it believes of the board's answers. Pure:
// each event comes with the time and gives an output; the shell around it (lcm_backend.hpp) turns
// datagrams and timers into events and the output into datagrams.
//
// clang-format off
//             100 ms of responses                a command
//   looking ───────────────────────▶ holding ───────────────▶ commanding ── 20 frames a second
//    ▲  ▲        it holds the body where it is                   │   │
//    │  └────────── the board restarted ─────────────────────────┤   │ another program's frame
//    └── 600 ms without one ── yielding ◀────────────────────────┴───┘
// clang-format on
//
// Rules:
//   - The board knows a new command by a life count that differs from the last one, and lies down
//     after 500 ms without a frame. Each command gets the next count and is repeated, because
//     datagrams are lost: 50 times a second until the board has taken it, for 200 ms at most, then
//     20 times. A process that hangs sends nothing, so the body lies down.
//   - Once the board has taken a command, heartbeats follow: frames of the same count and mode -1,
//     which is no command. The command itself would be new to a board that has restarted, and to
//     one whose last frame was another program's. Where no report can show that it is taken,
//     because the body was in the same mode and gait before, it is repeated for 200 ms. Reports are
//     handed on as ambiguous then: for 250 ms, or until a transition or less progress than before
//     shows that the command has begun. Stops are repeated as they are.
//   - A stop gets the next count with each frame until the board shows it. The same for the hold of
//     a body that walks, until the odometry shows that it is still, for 500 ms at most.
//   - After 500 ms in which this process hung, or its computer was suspended, the link looks again.
//     The same after 500 ms of a silent board, but a motion that neither walks nor stops is kept up
//     by heartbeats.
//   - A command that the board has not taken after LinkOptions.give_up has failed: it is sent no
//     longer, because it would begin whenever the board can take it. Only stops are kept.
//   - A process begins by looking: it sends nothing before it has received responses for 100 ms.
//     Its first frame is no motion: a body that lies goes on lying, one that stands by recovery
//     stand or walks is held in its place with zero speed; a gait that does not stay in its place
//     becomes WALK_STAND. It is sent with two life counts, of which one at least differs from that
//     of the commander before. A body in another motion ends it first, and one that is off stays
//     off: nothing is sent to it.
//   - An emergency stop is sent at once, in each situation, three times because datagrams are lost,
//     and repeated until recovery stand follows. Only recovery stand follows it. After a hang, and
//     after a silence of the board, it is new to the board once more.
//   - While the board reports an emergency stop, its damping mode or that it is off, only recovery
//     stand and the emergency stop are sent.
//   - A lifted body has its walk stopped, and begins none: its board would go on with it once the
//     body is put down.
//   - Without a response for 500 ms a walk is stopped, and no motion begins. A walk that the motion
//     manager has not repeated for 500 ms is stopped, too: its clock may stand still.
//   - While another program commands the board, only commands that stop are sent, for 200 ms or
//     until the board has taken them. The same for 1 s after a response of a second board, which
//     takes the same commands. Heartbeats go on then; without a command only to a body that lies
//     or stands.
//   - A frame that moves the motors directly has precedence over all commands, stops too, until the
//     board is switched off and on: nothing begins until it has restarted, and stops are sent.
//   - The board is the host that LinkOptions.board names, else the first one that responds.
//   Messages
//     of other hosts are dropped. All addresses of this computer are one host.
//   - A board that LinkOptions.board does not name may get another address. A host is taken for it
//     that began to respond when the board had ended, in the network of this computer, once for
//     1.5 s the board was silent and no third host has responded. A host that has responded beside
//     the board never is: it is another robot's. Nothing that was commanded before holds then, but
//     an emergency stop.
//   - A datagram that is older than the newest of its sender is dropped. A board that answers from
//     another port, or counts from the beginning, after 200 ms of silence has restarted: nothing
//     that was commanded before holds.
//
// Threads: any; a plain value.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/motion/board_message.hpp"
#include "musher/transport/lcm_packet.hpp"

namespace musher::motion {

inline constexpr Duration kHeartbeatPeriod = Milliseconds(50);  // between two frames: 20 Hz
inline constexpr Duration kUntilTaken = Milliseconds(20);       // the same, while it is not taken
inline constexpr Duration kRepeatTime = Milliseconds(200);  // of a command that reports cannot show
// Such a command has begun by then: the board reports every 20 ms.
inline constexpr Duration kBegunWithin = kRepeatTime + Milliseconds(50);
inline constexpr Duration kHoldTime = Milliseconds(500);      // of a walk, at most
inline constexpr Duration kLookTime = Milliseconds(100);      // from the first response
inline constexpr Duration kNoResponse = Milliseconds(500);    // then the board is silent
inline constexpr Duration kNoRepetition = Milliseconds(500);  // of a walk: it is stopped then
// After the last frame of another program it has ended: a board takes frames from 2 Hz on.
inline constexpr Duration kOtherSender = Milliseconds(600);
inline constexpr Duration kSecondBoard = Milliseconds(1000);  // the same of a second board
inline constexpr Duration kRestartPause = Milliseconds(200);  // after which counts may restart
// Of a board before another host is taken for it: three times the 500 ms after which the board
// itself takes its commander for lost.
inline constexpr Duration kNewAddress = 3 * kNoResponse;
// That have responded beside the board. Where there are more no other one is taken for it.
inline constexpr std::size_t kMostOtherHosts = 8;
inline constexpr Duration kControlPeriod = Milliseconds(10);  // an answer takes one at least
inline constexpr Duration kBetweenReports = Milliseconds(10);
inline constexpr Duration kSameFault = std::chrono::seconds(180);  // reported once in that time
// A second: the board sends 50, and 500 while a motion is nearly complete.
inline constexpr int kMostResponses = 1000;
inline constexpr int kStopCopies = 3;

// What a number that its sender counts up says of a datagram.
class NewestOnly {
 public:
  enum class Age { kNew, kOld, kRestarted };
  Age Take(std::uint32_t number, Time now);

  friend bool operator==(const NewestOnly&, const NewestOnly&) = default;

 private:
  std::optional<std::uint32_t> newest_;
  Time newest_at_{};
};

struct LinkFault {
  std::int32_t code = 0;
  std::string text;

  friend bool operator==(const LinkFault&, const LinkFault&) = default;
};

struct LinkOutput {
  std::vector<BodyCommand> frames;  // to send at once, in this order
  std::optional<BodyState> body;    // to hand on
  bool restarted = false;           // the board: what it was doing is void
  // Why only stops are sent: "another program commands the motion board: 192.168.44.1:41234 …", or
  // that there are two boards; "": no longer. nullopt: as before.
  std::optional<std::string> held_by;
  std::vector<LinkFault> faults;
};

struct LinkOptions {
  // How long a command is repeated that the board has not taken: as long as its caller waits for
  // that. Afterwards it must not begin.
  Duration give_up = kNoResponse;
  std::string board;  // its address, "192.168.44.233"; empty: the first host that responds
};

class LcmLink {
 public:
  explicit LcmLink(Time now, LinkOptions options = {})
      : options_(std::move(options)), tick_at_(now + kHeartbeatPeriod), second_began_(now) {
    body_.has_new_motion = false;
  }

  // Whose datagram it is, its number, where its host is (of the board's own host that is not used),
  // and how long ago it was received.
  struct Sender {
    std::string name;
    std::uint32_t sequence = 0;
    transport::HostPlace place = transport::HostPlace::kThisNetwork;
    Duration age{};
  };

  LinkOutput OnCommand(const BodyCommand& command, Time now);
  // `stamp` goes into the odometry. Each of the three messages has one sender; those of a second
  // one are ignored and reported.
  LinkOutput OnResponse(const Sender& sender, const BodyReport& report, Time now);
  LinkOutput OnLocation(const Sender& sender, const BoardLocation& location, Duration stamp,
                        Time now);
  LinkOutput OnTemperatures(const Sender& sender, const Temperatures& temperatures, Time now);
  // A frame on the board's channel that is not of this process.
  LinkOutput OnOtherFrame(const std::string& sender, const BodyCommand& frame, Time now);
  // The same on the channel of its motors.
  LinkOutput OnMotorFrame(const std::string& sender, Time now);
  // What was received on the channel, and why it is dropped.
  LinkOutput OnMalformed(const std::string& channel, const std::string& what, Time now);
  LinkOutput OnSendFailed(const Error& error, Time now);
  LinkOutput OnTime(Time now);
  // This computer was suspended, which `now` does not count: as after a hang of that time.
  void OnSuspended(Duration duration);

  // When to call OnTime().
  Time NextDeadline() const;

  // Whether that sender has the address of the board.
  bool IsHostOfBoard(const std::string& sender) const;
  // Whether that sender is on the host of the board.
  bool IsOnHostOfBoard(const Sender& sender) const;

  bool HasResponded() const { return responses_.at.has_value(); }
  // Whether the board has sent no response for 500 ms.
  bool Silent(Time now) const { return !responses_.at || now - *responses_.at >= kNoResponse; }
  bool looking() const { return looking_; }
  const std::optional<BodyCommand>& frame() const { return frame_; }  // that is repeated

 private:
  // Messages of one channel, of one sender.
  struct Stream {
    std::string sender;
    NewestOnly order;
    std::optional<Time> at;
  };

  bool HasOtherSender(Time now) const { return other_at_ && now - *other_at_ < kOtherSender; }
  bool HasSecondBoard(Time now) const {
    return second_board_at_ && now - *second_board_at_ < kSecondBoard;
  }
  bool Held(Time now) const { return motors_taken_ || HasOtherSender(now) || HasSecondBoard(now); }
  bool MaySend(const BodyCommand& command, Time now) const;
  bool IsBoard(const Stream& stream, const Sender& sender) const;
  void NoteOtherHost(const Sender& sender, Time now);
  bool HasMovedTo(const Sender& sender, Time now) const;
  // Whether the message is to be used; kRestarted: and its count has restarted, or the sender is
  // another one.
  NewestOnly::Age Take(Stream& stream, const Sender& sender, Time now, LinkOutput& output);
  void NoteSecondBoard(const Stream& stream, const std::string& board, const Sender& second,
                       Time now, LinkOutput& output);
  void Yield(const std::string& why, Time now, LinkOutput& output);
  void RenewStop(Time now);
  void Restart(Time now, LinkOutput& output);
  void Look(std::optional<Time> end);
  bool HasHung(Time now);
  bool WaitsForStop() const;
  void Hold(Time now, LinkOutput& output);
  void Begin(const BodyCommand& command, Time now, LinkOutput& output, int copies);
  void Renew(Time now, LinkOutput& output, int copies);
  void Repeat(Time now, LinkOutput& output);
  bool HasStopped() const;
  bool IsRenewed(Time now) const;
  bool IsStill() const;
  bool IsKnown(Time now) const;
  bool GoesOn(const BodyReport& report, Time now) const;
  bool KeepsBodyUp(Time now) const;
  BodyCommand Heartbeat() const;
  Duration Period(Time now) const;
  void NoteBegun();
  void NoteTaken();
  void HandOn(Time now, LinkOutput& output);
  void WatchRate(Time now, LinkOutput& output);
  void Fault(const std::string& kind, LinkFault fault, Time now, LinkOutput& output);

  LinkOptions options_;

  // What is sent.
  std::optional<BodyCommand> frame_;
  std::uint8_t life_ = 0;            // of the last new frame
  bool counted_ = false;             // the board's count is one of ours: the next one is new to it
  int recounts_ = 0;                 // frames that still get another life count
  std::int8_t wanted_ = 0;           // life count of the motion manager's last command
  Time kept_at_{};                   // the motion manager's last command, repeated or not
  std::int8_t taken_ = 0;            // the same, once the board has taken it
  bool own_ = false;                 // frame_ is the link's: it holds or stops the body
  Time begun_at_{};                  // frame_
  std::optional<Time> unconfirmed_;  // since when frame_ waits to be taken
  bool ambiguous_ = false;           // reports do not show it: the body was in that motion before
  std::int8_t bar_ = 0;              // of the last report that may be of the motion before
  bool begun_ = false;               // shown by a report, although ambiguous_
  bool was_changing_ = false;        // the body was in a transition when frame_ began, and still is
  Time tick_at_;                     // of the next frame
  bool stopped_ = false;             // emergency stop: only recovery stand follows

  // What the board says.
  bool looking_ = true;
  std::optional<Time> look_end_;  // from the first response on
  Stream responses_;
  bool on_this_computer_ = false;  // the board
  // Other hosts that have responded: since when, and when last.
  struct OtherHost {
    Time first_at{};
    Time last_at{};
  };
  std::map<std::string, OtherHost, std::less<>> other_hosts_;
  Stream locations_;
  Duration location_stamp_{};  // of the last one, by the clock of the board
  Stream temperatures_;
  BodyState body_;
  bool pending_ = false;  // body_ is not handed on yet
  Time received_at_{};    // its report, which may have waited for the loop
  std::optional<Time> handed_on_;
  Time second_began_;
  int in_second_ = 0;  // responses

  bool held_ = false;                    // as reported by held_by
  bool motors_taken_ = false;            // by a program that moves them directly
  std::optional<Time> other_at_;         // the last frame of another program
  std::optional<Time> second_board_at_;  // the last response of one
  std::map<std::string, Time> reported_;
};

}  // namespace musher::motion
