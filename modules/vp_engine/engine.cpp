#include "musher/modules/vp_engine/engine.hpp"

#include <utility>

#include "musher/application/groot2/groot2_server.hpp"
#include "musher/application/load_tree.hpp"
#include "musher/base/work_queue.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/modules/vp_engine/nodes.hpp"

namespace musher::vp_engine {
namespace {

tree::Reading ReadProgram(const std::string& name, const std::string& text) {
  // Else the errors of a program would show what is in other files.
  return tree::ReadTree(text, name + ".xml", [](const std::string& path) -> Result<std::string> {
    return Error{kCodeParametersInvalid, path + " is not read: a program is one file"};
  });
}

std::string ErrorsOf(const std::string& name, const std::string& text,
                     const tree::Factory& factory) {
  const tree::Reading read = ReadProgram(name, text);
  if (!read.ok()) return ErrorLines(read.diagnostics);
  const tree::Built built = tree::Build(read.document, factory);
  return built.tree == nullptr ? ErrorLines(built.diagnostics) : "";
}

}  // namespace

// The thread that checks and stores programs.
struct Engine::Background {
  explicit Background(transport::EventLoop& of) : loop(of) {}

  transport::EventLoop& loop;
  tree::Factory factory;                   // of the thread
  WorkQueue thread{{.name = "programs"}};  // last: it uses the rest
};

Engine::Engine(const std::string& actuator, const VpConfig& config)
    : TreeActuator(actuator,
                   {.rate_hz = config.rate_hz,
                    .record = {.file = config.record, .most_bytes = config.record_mib << 20}}),
      config_(config),
      robot_(config),
      programs_(config.folder, config.examples,
                [this](const std::string& name, const std::string& text) {
                  return ErrorsOf(name, text, factory());
                }) {}

Result<> Engine::RegisterNodes(tree::Factory& factory) {
  if (Result<> opened = programs_.Open(); !opened) return opened;
  return AddNodes(factory, robot_);
}

void Engine::OpenTopics(transport::Endpoints& topics) {
  robot_.Open(topics);
  const auto background = std::make_shared<Background>(topics.node().loop());
  if (const Result<> added = AddNodes(background->factory, robot_); !added) Log(added.error());
  topics.Keep(background);
  background_ = background;
  topics.Serve<msg::ManageProgram>(name() + "/manage_program",
                                   [this](const auto& request, auto reply) {
                                     if (request.operation == msg::ManageProgram::kAdd)
                                       return AddProgram(request, reply);
                                     reply(Manage(request));
                                   });
  if (config_.groot2_port == 0) return;
  const Result<> served = groot2::Serve(
      topics,
      {.port = config_.groot2_port,
       .address = config_.groot2_address,
       .hooks = config_.groot2_hooks,
       .on_lost = [this] { StopLost(); }},
      [this] { return view(); }, factory());
  if (!served) Log(served.error());  // programs run without it
}

void Engine::AddProgram(const msg::ManageProgram::Request& request, Reply reply) {
  const Result<std::string> path = programs_.BeginAdd(request.program, request.text);
  const auto background = background_.lock();
  if (!path || background == nullptr) {
    msg::ManageProgram::Response refused;
    refused.message = path ? "its topics are closed" : path.error().message;
    return reply(refused);
  }
  background->thread.Do([this, here = background_, it = background.get(), path = path.value(),
                         program = request.program, text = request.text, reply = std::move(reply)] {
    const std::string errors = ErrorsOf(program, text, it->factory);
    const Result<> stored = errors.empty() ? Programs::Store(path, text) : Ok();
    it->loop.Post([this, here, program, text, reply, errors, stored] {
      if (here.expired()) return;
      const Result<> done = programs_.EndAdd(program, text, errors, stored);
      msg::ManageProgram::Response response;
      response.success = done.ok();
      if (!done) response.message = done.error().message;
      reply(response);
    });
  });
}

msg::ManageProgram::Response Engine::Manage(const msg::ManageProgram::Request& request) {
  using Op = msg::ManageProgram;
  msg::ManageProgram::Response reply;
  Result<> done;
  switch (request.operation) {
    case Op::kList:
      for (Program& each : programs_.List()) {
        reply.programs.push_back(
            {std::move(each.name), std::string(Name(each.state)), std::move(each.message)});
      }
      break;
    case Op::kGet: {
      Result<std::string> text = programs_.Text(request.program);
      if (text)
        reply.text = std::move(text).value();
      else
        done = text.error();
      break;
    }
    case Op::kDelete:
      done = programs_.Remove(request.program);
      break;
    case Op::kRun:
      done = RunProgram(request);
      break;
    case Op::kStop:
      done = StopProgram(request.program);
      break;
    default:
      done = Error{kCodeParametersInvalid,
                   "unknown operation " + std::to_string(request.operation) + "; expected 0 to 5"};
  }
  reply.success = done.ok();
  if (!done) reply.message = done.error().message;
  return reply;
}

Result<> Engine::RunProgram(const msg::ManageProgram::Request& request) {
  if (!ticking()) {
    return Error{kCodeStateInvalid, name() + " runs programs in Active only; the robot is in " +
                                        CurrentState() +
                                        (HeldByStop() ? ", held by the emergency stop" : "")};
  }
  if (Result<> timely = CheckNotLate(); !timely) return timely;
  const Result<std::string> text = programs_.Runnable(request.program);
  if (!text) return text.error();
  Entries entries;
  for (const msg::ProgramSetting& each : request.settings)
    entries.emplace_back(each.key, each.value);
  tree::Reading read = ReadProgram(request.program, text.value());
  if (Result<> loaded = Load(std::move(read.document), entries); !loaded) {
    // The program before could not be halted.
    if (result() == tree::Status::kFailure && !programs_.running().empty()) {
      programs_.Ended(ProgramState::kFailed, last_fault());
    }
    return loaded;
  }
  programs_.Ended(ProgramState::kStopped, "replaced by " + request.program);
  programs_.Started(request.program);
  Log("program " + request.program + " started");
  return Ok();
}

Result<> Engine::StopProgram(const std::string& program) {
  const std::string& running = programs_.running();
  if (running.empty() || (!program.empty() && program != running)) {
    return Error{kCodeParametersInvalid, program.empty()
                                             ? "no program is running"
                                             : "program '" + program + "' is not running"};
  }
  Halt();
  Log("program " + running + " stopped");
  programs_.Ended(ProgramState::kStopped, "stopped on request");
  return Ok();
}

void Engine::StopLost() {
  Log(LogLevel::kWarning, "Groot2 is lost, and its hooks held or replaced a node: stopped");
  Halt();
  if (!programs_.running().empty()) programs_.Ended(ProgramState::kStopped, "Groot2 is lost");
}

void Engine::OnBreak() {
  if (programs_.running().empty()) return;
  Halt();
  programs_.Ended(ProgramState::kStopped, "its process could not run for more than a minute");
}

void Engine::AfterTick(Time /*now*/, tree::Status status) {
  if (status == tree::Status::kIdle || status == tree::Status::kRunning) return;
  const bool failed = status == tree::Status::kFailure;
  std::string why = last_fault();
  if (failed && why.empty()) why = "its tree ended with FAILURE";
  programs_.Ended(failed ? ProgramState::kFailed : ProgramState::kSucceeded, failed ? why : "");
}

Result<> Engine::OnStartCommand() {
  return Error{kCodeParametersInvalid, "a program is run by " + name() + "/manage_program"};
}

void Engine::OnPause() {
  // It does not begin again at the next Active, whatever began it.
  if (has_tree() && !tree::IsCompleted(result())) Halt();
  if (programs_.running().empty()) return;
  programs_.Ended(ProgramState::kStopped,
                  EmergencyStopped() ? "an emergency stop" : "the robot left Active");
}

}  // namespace musher::vp_engine
