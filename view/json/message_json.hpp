#pragma once
// Messages as JSON: the bytes of any type in the IDL as an object with its fields, for the page,
// and the bytes of such an object.
//
//   MessageJson json;
//   json.ToJson("std_msgs::msg::dds_::String_", bytes)             // {"data":"hello"}
//   json.FromJson("std_msgs::msg::dds_::String_", R"({"data":"hello"})")
//
//   an integer beyond ±2^53, which JavaScript would round    decimal text: "1765432101234567890"
//   NaN, infinity                                            null
//   more than kMostBytes bytes (a picture)                   {"bytes":921600}
//   text that is not UTF-8                                   with U+FFFD for each wrong byte
//   fields that an older peer has not sent                   left out
//
// FromJson() reads the same: an integer of 64 bits as number or text, null as NaN, a field that is
// not given as zero, "" or empty. A field that the type does not have is an error, as is a value
// that the field cannot hold, {"bytes":921600} included.
//
// The client's id and the sequence number of a service's request or response are not in its object;
// FromJson() writes zeros.
//
// Threads: one at a time. Errors: kCodeParametersInvalid with a sentence for a type that the IDL
// does not define, for bytes or text that are not a message of the type, and for more than
// kMostText or kMostWritten.

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/messages/cdr.hpp"

namespace musher::view {

struct MessageLayout;

class MessageJson {
 public:
  static constexpr std::size_t kMostBytes = 256;
  static constexpr std::size_t kMostText = std::size_t{4} << 20;      // bytes
  static constexpr std::size_t kMostWritten = std::size_t{16} << 20;  // by FromJson

  MessageJson();
  ~MessageJson();
  MessageJson(const MessageJson&) = delete;
  MessageJson& operator=(const MessageJson&) = delete;

  // `cdr`: with its header of four bytes, as on the wire.
  Result<std::string> ToJson(std::string_view dds_type, std::span<const std::byte> cdr);
  // Little-endian, with its header of four bytes.
  Result<msg::Bytes> FromJson(std::string_view dds_type, std::string_view text);

 private:
  static Error UnknownType(std::string_view dds_type);
  const MessageLayout* LayoutOf(std::string_view dds_type);

  std::map<std::string, std::unique_ptr<const MessageLayout>, std::less<>> layouts_;
};

}  // namespace musher::view
