#pragma once
// Events that carry data: a struct whose fields are saved like those of a state.
//
//   struct Photo {
//     std::int64_t count = 1;
//     void Persist(fsm::Archive& archive) { archive.Field("count", count); }
//   };
//   machine.AddEvent<Photo>("photo");
//   machine.Send("photo", Photo{.count = 3});
//
// and in a state
//
//   void Declare(fsm::Transitions& transitions) override {
//     photo_ = transitions.On<Photo>("photo");
//   }
//   fsm::Next CheckTransition(const fsm::Tick& tick) override {
//     if (const Photo* photo = photo_.In(tick)) ...
//
// The fields are recorded, replayed, saved and restored with the event.
// Threads: that of the machine. Errors: bugs are asserted.

#include <functional>
#include <memory>
#include <utility>

#include "musher/behavior/fsm/archive.hpp"
#include "musher/behavior/fsm/ids.hpp"

namespace musher::fsm {

class EventData;

// The type of the data of an event. One object for each: types are compared by their address.
struct EventType {
  std::function<std::shared_ptr<EventData>()> make;  // with the defaults of its fields
};

class EventData {
 public:
  virtual ~EventData() = default;
  virtual const EventType* type() const = 0;
  virtual void Persist(Archive& archive) = 0;
};

template <class T>
const EventType* EventTypeOf();

template <class T>
class EventDataOf final : public EventData {
 public:
  explicit EventDataOf(T initial = {}) : value(std::move(initial)) {}
  const EventType* type() const override { return EventTypeOf<T>(); }
  void Persist(Archive& archive) override { value.Persist(archive); }

  T value;
};

template <class T>
const EventType* EventTypeOf() {
  static const EventType type{[] { return std::make_shared<EventDataOf<T>>(); }};
  return &type;
}

struct Tick;

// An event that carries a T.
template <class T>
struct TypedEvent {
  EventId id = kNoEvent;

  // The data, where the command of the tick is this event; else null.
  const T* In(const Tick& tick) const;
};

}  // namespace musher::fsm
