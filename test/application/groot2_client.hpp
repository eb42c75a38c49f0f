#pragma once
// Requests of a client that speaks the protocol of Groot2, by a socket of ZeroMQ.

#include <zmq.h>

#include <nlohmann/json.hpp>
#include <string>

#include "musher/application/groot2/groot2_server.hpp"
#include "musher/application/groot2/groot2_session.hpp"

namespace musher::groot2 {

inline std::string Header(char type) {
  return {2, type, 'a', 'b', 'c', 'd'};
}

inline Parts Receive(void* socket) {
  Parts reply;
  for (int more = 1; more != 0;) {
    zmq_msg_t part;
    zmq_msg_init(&part);
    if (zmq_msg_recv(&part, socket, 0) < 0) return reply;
    reply.emplace_back(static_cast<const char*>(zmq_msg_data(&part)), zmq_msg_size(&part));
    more = zmq_msg_more(&part);
    zmq_msg_close(&part);
  }
  return reply;
}

// Empty where no reply comes within the timeout of the socket.
inline Parts Ask(void* socket, const Parts& request) {
  for (std::size_t i = 0; i < request.size(); ++i) {
    zmq_send(socket, request[i].data(), request[i].size(),
             i + 1 < request.size() ? ZMQ_SNDMORE : 0);
  }
  return Receive(socket);
}

// Mode 0: a breakpoint; 1: the node is replaced.
inline std::string HookJson(int uid, int mode, const std::string& status, bool once = false,
                            int position = 0) {
  return nlohmann::json{{"enabled", true}, {"uid", uid},           {"mode", mode},
                        {"once", once},    {"position", position}, {"desired_status", status}}
      .dump();
}

}  // namespace musher::groot2
