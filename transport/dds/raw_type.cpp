#include "musher/transport/dds/raw_type.hpp"

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <utility>

namespace musher::transport::dds {

namespace {

// Cyclone may read up to the next multiple of four, so the buffer has that size.
constexpr std::size_t Padded(std::size_t size) {
  return (size + 3) & ~std::size_t{3};
}

struct RawData : ddsi_serdata {
  RawData(const ddsi_sertype* sertype, ddsi_serdata_kind data_kind, msg::Bytes data)
      : ddsi_serdata{}, size(data.size()), bytes(std::move(data)) {
    bytes.resize(Padded(size));
    ddsi_serdata_init(this, sertype, data_kind);
    hash = sertype->serdata_basehash;  // keyless: all samples belong to the same instance
  }

  std::size_t size;
  msg::Bytes bytes;
};

// Reserves so many bytes, so that padding does not reallocate; a picture is large.
msg::Bytes Reserved(std::size_t size) {
  msg::Bytes bytes;
  bytes.reserve(Padded(size));
  return bytes;
}

const RawData& AsRaw(const ddsi_serdata* data) {
  return *static_cast<const RawData*>(data);
}

bool EqualKey(const ddsi_serdata*, const ddsi_serdata*) {
  return true;
}

std::uint32_t SizeOf(const ddsi_serdata* data) {
  return static_cast<std::uint32_t>(AsRaw(data).size);
}

// Fragments arrive in order and may overlap.
ddsi_serdata* FromFragments(const ddsi_sertype* type, ddsi_serdata_kind kind,
                            const nn_rdata* fragment, std::size_t size) {
  msg::Bytes bytes = Reserved(size);
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    const std::size_t filled = bytes.size();
    const std::size_t end = std::min<std::size_t>(fragment->maxp1, size);
    if (end <= filled) continue;
    if (fragment->min > filled) return nullptr;
    const auto* payload = reinterpret_cast<const std::byte*>(
        NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment)));
    bytes.insert(bytes.end(), payload + (filled - fragment->min), payload + (end - fragment->min));
  }
  return bytes.size() == size ? new RawData(type, kind, std::move(bytes)) : nullptr;
}

ddsi_serdata* FromBuffers(const ddsi_sertype* type, ddsi_serdata_kind kind,
                          ddsrt_msg_iovlen_t count, const ddsrt_iovec_t* buffers,
                          std::size_t size) {
  msg::Bytes bytes = Reserved(size);
  for (ddsrt_msg_iovlen_t i = 0; i < count; ++i) {
    const auto* part = static_cast<const std::byte*>(buffers[i].iov_base);
    bytes.insert(bytes.end(), part,
                 part + std::min<std::size_t>(buffers[i].iov_len, size - bytes.size()));
  }
  bytes.resize(size);
  return new RawData(type, kind, std::move(bytes));
}

ddsi_serdata* FromKeyHash(const ddsi_sertype* type, const ddsi_keyhash*) {
  return new RawData(type, SDK_KEY, {});
}

ddsi_serdata* FromSample(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* sample) {
  return new RawData(type, kind, std::move(static_cast<const RawSample*>(sample)->bytes));
}

void ToBuffer(const ddsi_serdata* data, std::size_t offset, std::size_t size, void* buffer) {
  std::memcpy(buffer, AsRaw(data).bytes.data() + offset, size);
}

ddsi_serdata* Lend(const ddsi_serdata* data, std::size_t offset, std::size_t size,
                   ddsrt_iovec_t* reference) {
  reference->iov_base = const_cast<std::byte*>(AsRaw(data).bytes.data()) + offset;
  reference->iov_len = static_cast<ddsrt_iov_len_t>(size);
  return ddsi_serdata_ref(data);
}

void GiveBack(ddsi_serdata* data, const ddsrt_iovec_t*) {
  ddsi_serdata_unref(data);
}

ddsi_serdata* ToKey(const ddsi_serdata* data) {
  auto* key = new RawData(data->type, SDK_KEY, {});
  key->type = nullptr;  // a key is shared by types
  return key;
}

// Samples are only taken as serialised data (dds_takecdr).
bool ToSample(const ddsi_serdata*, void*, void**, void*) {
  return false;
}
bool KeyToSample(const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) {
  return false;
}

void FreeRawSample(ddsi_serdata* data) {
  delete static_cast<RawData*>(data);
}

std::size_t Print(const ddsi_sertype*, const ddsi_serdata* data, char* text, std::size_t size) {
  return static_cast<std::size_t>(std::snprintf(text, size, "%u bytes", SizeOf(data)));
}

void KeyHash(const ddsi_serdata*, ddsi_keyhash* hash, bool) {
  *hash = {};
}

constexpr ddsi_serdata_ops kDataOps = [] {
  ddsi_serdata_ops ops{};
  ops.eqkey = EqualKey;
  ops.get_size = SizeOf;
  ops.from_ser = FromFragments;
  ops.from_ser_iov = FromBuffers;
  ops.from_keyhash = FromKeyHash;
  ops.from_sample = FromSample;
  ops.to_ser = ToBuffer;
  ops.to_ser_ref = Lend;
  ops.to_ser_unref = GiveBack;
  ops.to_sample = ToSample;
  ops.to_untyped = ToKey;
  ops.untyped_to_sample = KeyToSample;
  ops.free = FreeRawSample;
  ops.print = Print;
  ops.get_keyhash = KeyHash;
  return ops;
}();

void FreeType(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete type;
}

// Types of the same name are the same type.
bool EqualType(const ddsi_sertype*, const ddsi_sertype*) {
  return true;
}
std::uint32_t HashType(const ddsi_sertype*) {
  return 0;
}

// The null functions are for types that Cyclone encodes itself, or for shared memory.
const ddsi_sertype_ops kTypeOps = [] {
  ddsi_sertype_ops ops{};
  ops.version = ddsi_sertype_v0;
  ops.free = FreeType;
  ops.equal = EqualType;
  ops.hash = HashType;
  return ops;
}();

}  // namespace

dds_entity_t CreateRawTopic(dds_entity_t participant, const std::string& name,
                            const std::string& type_name) {
  auto* type = new ddsi_sertype{};
  ddsi_sertype_init(type, type_name.c_str(), &kTypeOps, &kDataOps, true);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  const dds_entity_t topic =
      dds_create_topic_sertype(participant, name.c_str(), &type, nullptr, nullptr, nullptr);
  if (topic < 0) ddsi_sertype_unref(type);  // else it is Cyclone's
  return topic;
}

std::span<const std::byte> BytesOf(const ddsi_serdata* sample) {
  const RawData& data = AsRaw(sample);
  return std::span(data.bytes).first(data.size);
}

}  // namespace musher::transport::dds
