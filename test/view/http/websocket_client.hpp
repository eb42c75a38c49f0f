#pragma once
// A WebSocket client that sends and receives frames as bytes.

#include "musher/test/view/http/client.hpp"

namespace musher::http {

enum class Opcode : unsigned char {
  kContinuation = 0,
  kText = 1,
  kBinary = 2,
  kClose = 8,
  kPing = 9,
  kPong = 10,
};

struct Frame {
  bool last = true;
  Opcode opcode = Opcode::kText;
  std::string payload;
  bool ok = false;  // false: the connection ended before it

  unsigned close_code() const {
    if (opcode != Opcode::kClose || payload.size() < 2) return 0;
    return static_cast<unsigned char>(payload[0]) * 256u + static_cast<unsigned char>(payload[1]);
  }
};

// The head of a frame that claims `size` bytes, masked with zeros.
inline std::string FrameHead(Opcode opcode, std::uint64_t size, bool last = true) {
  std::string head(1, static_cast<char>(static_cast<unsigned char>(opcode) | (last ? 0x80 : 0)));
  if (size < 126) {
    head += static_cast<char>(0x80 | size);
  } else {
    const int bytes = size < 65536 ? 2 : 8;
    head += static_cast<char>(0x80 | (bytes == 2 ? 126 : 127));
    for (int i = bytes - 1; i >= 0; --i) head += static_cast<char>(size >> (8 * i));
  }
  return head + std::string(4, '\0');
}

inline std::string FrameBytes(Opcode opcode, std::string_view payload, bool last = true) {
  return FrameHead(opcode, payload.size(), last).append(payload);
}

class WebSocketClient : public Client {
 public:
  explicit WebSocketClient(std::uint16_t port, std::string_view path = "/",
                           std::string_view headers = {}, int receive_buffer = 0)
      : Client(port, receive_buffer) {
    Send("GET " + std::string(path) +
         " HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
         "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
         std::string(headers) + "\r\n");
    reply_ = TakeReply();
  }

  const Reply& reply() const { return reply_; }
  bool open() const { return reply_.status == 101; }

  bool SendFrame(Opcode opcode, std::string_view payload) {
    return Send(FrameBytes(opcode, payload));
  }
  Frame TakeFrame() {
    Frame frame;
    const std::string head = Take(2);
    if (head.size() < 2) return frame;
    frame.last = (head[0] & 0x80) != 0;
    frame.opcode = static_cast<Opcode>(head[0] & 0x0F);
    std::size_t size = head[1] & 0x7F;
    if (size >= 126) {
      const std::string length = Take(size == 126 ? 2 : 8);
      size = 0;
      for (const char c : length) size = size << 8 | static_cast<unsigned char>(c);
    }
    frame.payload = Take(size);
    frame.ok = frame.payload.size() == size;
    return frame;
  }
  // The next one that is not a ping.
  Frame TakeMessage() {
    while (true) {
      Frame frame = TakeFrame();
      if (!frame.ok || frame.opcode != Opcode::kPing) return frame;
    }
  }

 private:
  Reply reply_;
};

// Sends each message back.
inline WebSocketHandlers EchoWebSocket(const std::shared_ptr<WebSocket>& socket) {
  WebSocketHandlers handlers;
  handlers.on_message = [socket](const std::string& message, bool binary) {
    socket->Send(Shared(message), binary);
  };
  return handlers;
}

}  // namespace musher::http
