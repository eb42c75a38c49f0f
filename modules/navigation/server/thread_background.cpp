#include "musher/modules/navigation/server/thread_background.hpp"

#include <utility>

namespace musher::navigation {

ThreadBackground::~ThreadBackground() {
  *alive_ = false;
}

void ThreadBackground::Do(std::function<std::function<void()>()> work) {
  thread_.Do([this, work = std::move(work)] {
    loop_.Post([alive = alive_, then = work()] {
      if (*alive && then) then();
    });
  });
}

}  // namespace musher::navigation
