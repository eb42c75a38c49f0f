#pragma once
// The looks of a guest: a head with a face, on a body of rounded parts.
//
// Threads: immutable; any number of concurrent readers.

#include <memory>
#include <vector>

#include "musher/modules/world/paint/texture.hpp"
#include "musher/modules/world/render/scenery.hpp"
#include "musher/modules/world/simulation/guests.hpp"

namespace musher::world {

struct Figure {
  Figure(const GuestSpec& guest, Texture head);

  // Adds the parts of a guest who is present.
  void Stand(const Guest& guest, std::vector<Thing>& things) const;

 private:
  GuestSpec spec_;
  std::shared_ptr<const Texture> head_;
};

}  // namespace musher::world
