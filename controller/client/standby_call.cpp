#include "musher/controller/client/standby_call.hpp"

#include <span>
#include <utility>

#include "musher/base/host.hpp"

namespace musher {
namespace {

constexpr const char* kReportService = "standby";

// The name of the machine, its id and the reason, each on a line of its own.
msg::Bytes EncodeReport(const StandbyReport& report) {
  const std::string text = report.machine.name + "\n" + report.machine.id + "\n" + report.why_not;
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::optional<StandbyReport> DecodeReport(const msg::Bytes& bytes, pid_t pid) {
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t name_end = text.find('\n');
  if (name_end == std::string::npos) return std::nullopt;
  const std::size_t id_end = text.find('\n', name_end + 1);
  if (id_end == std::string::npos) return std::nullopt;
  return StandbyReport{{text.substr(0, name_end), text.substr(name_end + 1, id_end - name_end - 1)},
                       text.substr(id_end + 1),
                       pid};
}

}  // namespace

std::string StandbyName(int domain, std::string_view name_space) {
  return NameLock::NameOf(domain, name_space, "musher/standby");
}

Result<std::unique_ptr<StandbyServer>> StandbyServer::Make(transport::EventLoop& loop,
                                                           const std::string& name,
                                                           std::function<StandbyReport()> report) {
  auto server = transport::HostServer::Make(loop, name);
  if (!server) return server.error();
  server.value()->Offer(kReportService, [report = std::move(report)](
                                            auto, const transport::HostServer::Reply& reply) {
    reply(EncodeReport(report()));
  });
  return std::unique_ptr<StandbyServer>(new StandbyServer(std::move(server).value()));
}

std::unique_ptr<StandbyCall> StandbyCall::Make(transport::EventLoop& loop,
                                               const std::string& name) {
  std::unique_ptr<StandbyCall> standby(new StandbyCall);
  StandbyCall* const self = standby.get();
  self->call_ = transport::HostCall::Make(loop, name, kReportService, {},
                                          [self](const Result<msg::Bytes>& reply) {
                                            self->ended_ = true;
                                            if (!reply) return;
                                            self->report_ = DecodeReport(reply.value(), self->pid_);
                                          });
  if (!self->call_) return nullptr;
  self->pid_ = self->call_->server();
  return standby;
}

std::optional<StandbyReport> StandbyCall::Report() const {
  if (ended_) return report_;
  return StandbyReport{{}, "it does not answer", pid_};
}

}  // namespace musher
