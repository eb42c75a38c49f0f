#include "musher/modules/meilin/plan/planner_endpoint.hpp"

#include <fmt/format.h>

#include <sstream>
#include <utility>

#include "musher/messages/r2_interfaces/get_action_seq.hpp"
#include "musher/modules/meilin/plan/box_map_text.hpp"
#include "musher/modules/meilin/plan/plan_text.hpp"

namespace musher::meilin {

PlannerEndpoint::PlannerEndpoint(const PlannerDependencies& dependencies, PlannerConfig config)
    : dependencies_(dependencies),
      config_(std::move(config)),
      endpoints_(dependencies.node, dependencies.name_space) {}

Result<std::unique_ptr<PlannerEndpoint>> PlannerEndpoint::Make(
    const PlannerDependencies& dependencies, const PlannerConfig& config) {
  std::unique_ptr<PlannerEndpoint> endpoint(new PlannerEndpoint(dependencies, config));
  const Result<> opened = endpoint->Open();
  if (!opened) return opened.error();
  return endpoint;
}

Result<> PlannerEndpoint::Open() {
  const PlannerTopics& topics = config_.topics;
  publish_paths_ = endpoints_.PublishFunction<msg::String>(topics.paths, transport::kLatchedQos);
  publish_error_ =
      endpoints_.PublishFunction<msg::String>(topics.last_error, transport::kLatchedQos);
  publish_status_ =
      endpoints_.PublishFunction<msg::String>(topics.buffer_status, transport::kLatchedQos);
  publish_plan_ =
      endpoints_.PublishFunction<msg::Float32MultiArray>(topics.plan, transport::kLatchedQos);
  SetBuffer(std::nullopt);
  endpoints_.Subscribe<msg::String>(
      topics.map, [this](const msg::String& map) { OnMap(map.data); }, transport::kLatchedQos);
  endpoints_.Subscribe<msg::String>(
      topics.command, [this](const msg::String& command) { OnCommand(command.data); });
  endpoints_.Subscribe<msg::Float32MultiArray>(
      topics.plan, [this](msg::Float32MultiArray&& plan) { SetBuffer(std::move(plan)); },
      transport::kLatchedQos);
  endpoints_.Serve<msg::GetActionSeq>(
      topics.buffer_service, [this](const msg::GetActionSeq::Request&, const auto& reply) {
        if (!permitted_ || !buffer_) return reply({});
        msg::GetActionSeq::Response response{std::move(*buffer_), true};
        SetBuffer(std::nullopt);
        reply(response);
      });
  return endpoints_.opened();
}

void PlannerEndpoint::Permit(bool permitted, const std::string& why) {
  permitted_ = permitted;
  if (permitted) return;
  not_permitted_ = why;
  send_timer_.reset();
}

void PlannerEndpoint::SetBuffer(std::optional<msg::Float32MultiArray> plan) {
  buffer_ = std::move(plan);
  publish_status_({buffer_ ? "has_data" : "empty"});
}

void PlannerEndpoint::Report(const std::string& error) {
  publish_error_({error});
  if (!error.empty()) dependencies_.log(LogLevel::kWarning, error);
}

void PlannerEndpoint::OnMap(const std::string& text) {
  send_timer_.reset();
  const BoxMapReading reading = ReadBoxMapJson(text);
  if (!reading.map) {
    std::string faults;
    for (const std::string& fault : reading.faults) faults += (faults.empty() ? "" : "; ") + fault;
    return Report("a map of boxes is refused: " + faults);
  }
  report_ = FindRoutes(*reading.map, config_.rules);
  publish_paths_({RoutesJson(report_->routes)});
  const Route* best = BestRoute(report_->routes);
  if (best == nullptr)
    return Report(std::string("there is no plan for the map of boxes: ") + kNoPath);
  Report("");
  dependencies_.log(
      LogLevel::kInfo,
      fmt::format("a map of the {} field: the plan to send has {}{}", SideText(reading.map->side),
                  RouteSummary(*best), report_->complete ? "" : "; not all plans were searched"));
  if (config_.auto_send == Duration{} || !permitted_) return;
  send_timer_ = dependencies_.clock.At(dependencies_.clock.Now() + config_.auto_send,
                                       [this] { OnCommand("SEND"); });
}

Result<const Route*> PlannerEndpoint::Chosen(const std::string& command) const {
  std::istringstream words(command);
  std::string word;
  std::string rest;
  int count = -1;
  int index = 1;
  words >> word;
  if (word != "SEND") {
    return Error{kCodeFailed, "expected SEND, SEND <number of KFS2> or SEND <number> <index>"};
  }
  if (words >> count) words >> index;
  words.clear();
  if (words >> rest) return Error{kCodeFailed, "expected numbers after SEND"};
  if (!report_) return Error{kCodeFailed, "there is no map of boxes yet"};
  if (count < 0) {
    const Route* best = BestRoute(report_->routes);
    if (best == nullptr) return Error{kCodeFailed, "the last map of boxes has no plan"};
    return best;
  }
  const auto bucket = static_cast<std::size_t>(count);
  const bool known = bucket < report_->routes.size() && index >= 1 &&
                     static_cast<std::size_t>(index) <= report_->routes.at(bucket).routes.size();
  if (!known) {
    return Error{kCodeFailed, fmt::format("there is no plan {} with {} KFS2", index, count)};
  }
  return &report_->routes.at(bucket).routes.at(static_cast<std::size_t>(index - 1));
}

void PlannerEndpoint::OnCommand(const std::string& command) {
  send_timer_.reset();
  constexpr std::size_t kLongest = 40;
  const std::string quoted = "'" + command.substr(0, kLongest) + "'";
  if (!permitted_) return Report("command " + quoted + " is refused: " + not_permitted_);
  const Result<const Route*> route = Chosen(command);
  if (!route) return Report("command " + quoted + " is refused: " + route.error().message);
  Report("");
  Send(*route.value());
}

void PlannerEndpoint::Send(const Route& route) {
  dependencies_.log(LogLevel::kInfo, "a plan is sent: " + RouteSummary(route));
  publish_plan_(ToActionSequence(route.steps));
}

}  // namespace musher::meilin
