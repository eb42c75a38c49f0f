#pragma once
// Fields that several of CyberDog's interfaces of a voice have.

#include <protocol_audio.h>

#include "musher/messages/protocol/audio.hpp"
#include "musher/test/contract/wire_same.hpp"

namespace musher::msg {

MUSHER_SAME(protocol_msg_dds__AudioPlay_, AudioPlay) {
  SAME(module_name);
  SAME(play_id);
}

}  // namespace musher::msg
