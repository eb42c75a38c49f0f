// The messages of a robot's voice: as the IDL says.

#include <protocol_audio.h>

#include "musher/messages/protocol/audio.hpp"
#include "musher/test/contract/wire_exchange.hpp"
#include "musher/test/contract/wire_fields_audio.hpp"

namespace musher::msg {

MUSHER_SAME(protocol_msg_dds__AudioPlayExtend_, AudioPlayExtend) {
  SAME(module_name);
  SAME(is_online);
  SAME(speech);
  SAME(text);
}

MUSHER_SAME(protocol_msg_dds__AudioStatus_, AudioStatus) {
  SAME(state);
}

MUSHER_SAME(protocol_srv_dds__AudioTextPlay_Request_, AudioTextPlay::Request) {
  SAME(module_name);
  SAME(is_online);
  SAME(speech);
  SAME(text);
}
MUSHER_SAME(protocol_srv_dds__AudioTextPlay_Response_, AudioTextPlay::Response) {
  SAME(status);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__AudioVolumeGet_Request_, AudioVolumeGet::Request) {
  SAME(structure_needs_at_least_one_member);
}
MUSHER_SAME(protocol_srv_dds__AudioVolumeGet_Response_, AudioVolumeGet::Response) {
  SAME(volume);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__AudioVolumeSet_Request_, AudioVolumeSet::Request) {
  SAME(volume);
}
MUSHER_SAME(protocol_srv_dds__AudioVolumeSet_Response_, AudioVolumeSet::Response) {
  SAME(success);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__AudioExecute_Request_, AudioExecute::Request) {
  SAME(client);
  SAME(status);
}
MUSHER_SAME(protocol_srv_dds__AudioExecute_Response_, AudioExecute::Response) {
  SAME(result);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__SdcardPlayIdQuery_Request_, SdcardPlayIdQuery::Request) {
  SAME(play_id);
}
MUSHER_SAME(protocol_srv_dds__SdcardPlayIdQuery_Response_, SdcardPlayIdQuery::Response) {
  SAME(exist);
  SAME(code);
}

}  // namespace musher::msg

namespace musher::transport::wire_audio_test {

MESSAGE(protocol, AudioPlay)
MESSAGE(protocol, AudioPlayExtend)
MESSAGE(protocol, AudioStatus)
SERVICE(protocol, AudioTextPlay)
SERVICE(protocol, AudioVolumeGet)
SERVICE(protocol, AudioVolumeSet)
SERVICE(protocol, AudioExecute)
SERVICE(protocol, SdcardPlayIdQuery)

}  // namespace musher::transport::wire_audio_test
