#pragma once
// A participant of the robot's domain for Python, and how an endpoint of it lives on its loop.
//
// Threads: with the GIL, which is released while the loop works.

#include <unistd.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/python/native/mailbox.hpp"
#include "musher/python/native/parts.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/loop_breaks.hpp"
#include "musher/wire/node_services.hpp"

namespace musher::python {

// A fork has none of the threads of the process that has made a node or a mailbox. With the GIL.
[[noreturn]] inline void RaiseInFork(pid_t process) {
  Raise("Failure", {kCodeStateInvalid, "process " + std::to_string(process) +
                                           " has made this node, and this is a fork of it: make "
                                           "a node or a Machine of its own here"});
}

struct PyNode {
  std::shared_ptr<transport::NodeThread> thread;
  std::string name_space;
  std::unique_ptr<transport::NodeServices> services;  // of a node with a name; on the loop
  std::unique_ptr<transport::LoopBreaks> breaks;      // of an actuator's node; on the loop
  const pid_t process = getpid();

  PyNode(std::shared_ptr<transport::NodeThread> on, std::string in)
      : thread(std::move(on)), name_space(std::move(in)) {}
  PyNode(const PyNode&) = delete;
  PyNode& operator=(const PyNode&) = delete;
  ~PyNode() {
    if (!InThisProcess()) {
      LeaveToParent();
      return;
    }
    if (!services && !breaks) return;
    WithoutGil([this] {
      thread->RunOnLoop([this] {
        services.reset();
        breaks.reset();
      });
    });
  }

  // A fork has no thread of the loop, and would wait for it for ever.
  bool InThisProcess() const { return getpid() == process; }
  // Raises musher.Failure in a fork. With the GIL.
  void CheckProcess() const {
    if (!InThisProcess()) RaiseInFork(process);
  }

  std::string Resolve(const std::string& name) const {
    return transport::ResolveName(name_space, name);
  }

 private:
  void LeaveToParent() {
    static_cast<void>(services.release());
    static_cast<void>(breaks.release());
    // NOLINTNEXTLINE(cppcoreguidelines-owning-memory): its destructor waits for the loop
    static_cast<void>(new std::shared_ptr<transport::NodeThread>(std::move(thread)));
  }
};
using PyNodePtr = std::shared_ptr<PyNode>;
using MailboxPtr = std::shared_ptr<Mailbox>;

// An item that a node receives. On the loop; `breaks` may be null.
inline Item ReceivedItem(std::int64_t key, transport::LoopBreaks* breaks) {
  Item item;
  item.key = key;
  if (breaks != nullptr) item.after_break = breaks->Recent();
  return item;
}

// With the arguments of musher.Node. Raises musher.Failure.
PyNodePtr MakeNode(const std::string& name, const std::string& name_space,
                   std::optional<int> domain, const std::string& keys, const std::string& identity,
                   const std::string& interface);

// An object of the transport that is made, used and dropped on the loop.
template <class T>
class OnLoop {
 public:
  // `make(node)` returns a Result of a unique_ptr.
  template <class Make>
  OnLoop(PyNodePtr node, const Make& make) : node_(std::move(node)) {
    node_->CheckProcess();
    const Result<> made = WithoutGil([&] {
      Result<> result;
      node_->thread->RunOnLoop([&] {
        auto object = make(node_->thread->node());
        if (!object) {
          result = object.error();
        } else {
          object_ = std::move(object).value();
        }
      });
      return result;
    });
    Check(made);
  }
  ~OnLoop() { Close(); }
  OnLoop(const OnLoop&) = delete;
  OnLoop& operator=(const OnLoop&) = delete;

  void Close() {
    if (!node_) return;
    const PyNodePtr node = std::exchange(node_, nullptr);
    if (!node->InThisProcess()) {
      static_cast<void>(object_.release());  // it belongs to the parent
      return;
    }
    WithoutGil([&] { node->thread->RunOnLoop([&] { object_.reset(); }); });
  }
  // Runs `work(object)` on the loop and waits for it. Raises musher.Failure after Close(), and in a
  // fork.
  template <class Work>
  void Run(const Work& work) {
    const PyNodePtr node = node_;
    if (!node) Raise("Failure", {kCodeStateInvalid, "it is closed"});
    node->CheckProcess();
    bool closed = false;
    WithoutGil([&] {
      node->thread->RunOnLoop([&] {
        if (object_) {
          work(*object_);
        } else {
          closed = true;  // by another thread meanwhile
        }
      });
    });
    if (closed) Raise("Failure", {kCodeStateInvalid, "it is closed"});
  }

 private:
  PyNodePtr node_;
  std::unique_ptr<T> object_;  // used on the loop
};

// An encoded body behind an id: what a service sends.
msg::Bytes WithEnvelope(const msg::RequestId& id, std::span<const std::byte> message);

Duration Seconds(double seconds);

void AddNode(py::module_& native);
void AddServices(py::module_& native);
void AddActions(py::module_& native);

}  // namespace musher::python
