#include "musher/transport/dds/qos.hpp"

namespace musher::transport::dds {

QosPtr MakeQos(const Qos& qos, const std::string& user_data) {
  QosPtr out(dds_create_qos());
  const bool reliable = qos.reliability == Qos::Reliability::kReliable;
  const bool latched = qos.durability == Qos::Durability::kTransientLocal;
  const auto history = qos.depth == 0 ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST;
  const int depth = qos.depth == 0 ? DDS_LENGTH_UNLIMITED : qos.depth;

  dds_qset_reliability(out.get(), reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_history(out.get(), history, depth);
  dds_qset_durability(out.get(),
                      latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  if (qos.lifespan > Duration{}) dds_qset_lifespan(out.get(), qos.lifespan.count());
  if (latched) {  // how many samples a late joiner gets
    dds_qset_durability_service(out.get(), 0, history, depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  // A crash must not look like a disposal.
  dds_qset_writer_data_lifecycle(out.get(), false);

  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(out.get(), 1, &xcdr1);
  if (!user_data.empty()) dds_qset_userdata(out.get(), user_data.data(), user_data.size());
  if (!qos.partition.empty()) {
    const std::string name(qos.partition);
    const char* partition = name.c_str();
    dds_qset_partition(out.get(), 1, &partition);
  }
  return out;
}

}  // namespace musher::transport::dds
