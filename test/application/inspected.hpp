#pragma once

namespace musher::testing {

// Lets a test look at an application of its own, a `Self` that derives from it.
template <class Self>
class Inspected {
 public:
  // The result of `look`, between two ticks.
  template <class Look>
  auto Of(Look look) {
    Self& self = static_cast<Self&>(*this);
    decltype(look(self)) found{};
    self.RunOnLoop([&] { found = look(self); });
    return found;
  }
};

}  // namespace musher::testing
