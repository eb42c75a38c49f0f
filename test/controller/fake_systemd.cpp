// What a test reaches instead of another host: `controller_fake_systemd FOLDER` is the end of an
// ssh connection, and answers the calls of D-Bus as systemd does, for one unit. It has no process.
// `controller_fake_systemd FOLDER SOCKET` is the same for this host: it listens there, and serves
// one connection after the other.
//
//   FOLDER/unit           ActiveState, the pid of its last process, one variable of the environment,
//                         Result, and the exit code of that process; without that it still runs
//   FOLDER/system         SystemState; without it "running"
//   FOLDER/uptime         for how many seconds the host has run: a start whose limit is less is
//                         skipped; without it none is
//   FOLDER/job            the job of a start ends with the result in it, after FOLDER/started has
//                         become FOLDER/unit; without it no job ends that is not skipped
//   FOLDER/ignore-MEMBER  the calls of this member are not answered
//   FOLDER/refuse-MEMBER  the calls of this member are answered with the error in it
//   FOLDER/late-MEMBER    the calls of this member are answered once it is removed
//   FOLDER/changed        PropertiesChanged is sent once, without the environment; removed after
//   FOLDER/down           the connection ends; removed before
//   FOLDER/calls          written: the calls, a line each
//   FOLDER/reads          written: the same of the calls that read its state

#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

namespace {

struct Unit {
  std::string active = "inactive";
  std::uint32_t pid = 0;
  std::string variable;
  std::string result = "success";
  std::int32_t exit_code = -1;  // of its last process; -1: none has exited

  // Each process is of a start of its own.
  std::string invocation() const {
    std::string text = std::to_string(pid);
    return text.insert(0, 32 - text.size(), '0');
  }
  std::int32_t exec_code() const { return exit_code < 0 ? 0 : CLD_EXITED; }
  std::uint32_t main_pid() const { return exit_code < 0 ? pid : 0; }
};

class FakeSystemd {
 public:
  explicit FakeSystemd(std::string folder) : folder_(std::move(folder)) {}
  ~FakeSystemd() { sd_bus_unref(bus_); }
  FakeSystemd(const FakeSystemd&) = delete;
  FakeSystemd& operator=(const FakeSystemd&) = delete;

  int Run(int input, int output) {
    sd_id128_t id{};
    const bool made = sd_id128_randomize(&id) >= 0 && sd_bus_new(&bus_) >= 0 &&
                      sd_bus_set_fd(bus_, input, output) >= 0 &&
                      sd_bus_set_server(bus_, 1, id) >= 0 && sd_bus_set_anonymous(bus_, 1) >= 0 &&
                      sd_bus_add_filter(bus_, nullptr, &OnMessage, this) >= 0 &&
                      sd_bus_start(bus_) >= 0;
    if (!made) return 1;
    for (;;) {
      const int more = sd_bus_process(bus_, nullptr);
      if (more < 0) return 0;
      if (more > 0) continue;
      if (Take("down")) return 0;
      TellChange();
      if (sd_bus_wait(bus_, kLookEach_us) < 0) return 0;
    }
  }

 private:
  static int OnMessage(sd_bus_message* message, void* self, sd_bus_error* /*error*/) {
    if (sd_bus_message_is_method_call(message, nullptr, nullptr) <= 0) return 0;
    static_cast<FakeSystemd*>(self)->Answer(message);
    return 1;
  }

  void Answer(sd_bus_message* call) {
    const std::string member = sd_bus_message_get_member(call);
    if (Has("late-" + member)) {
      Note(member + " is late");
      while (Has("late-" + member)) {
        TellChange();
        sd_bus_wait(bus_, kLookEach_us);
      }
    }
    if (Has("refuse-" + member)) {
      std::ifstream file(folder_ + "/refuse-" + member);
      std::string name;
      file >> name;
      Note(member + " refused");
      sd_bus_reply_method_errorf(call, name.c_str(), "refused by the test");
    } else if (Has("ignore-" + member)) {
      Note(member + " ignored");
    } else if (member == "Get") {
      std::string state = "running";
      std::ifstream(folder_ + "/system") >> state;
      sd_bus_reply_method_return(call, "v", "s", state.c_str());
    } else if (member == "Hello") {
      sd_bus_reply_method_return(call, "s", ":1.1");
    } else if (member == "GetAll") {
      AnswerProperties(call);
    } else if (member == "Kill") {
      AnswerKill(call);
    } else if (member == "StartTransientUnit") {
      AnswerStart(call);
    } else {
      if (member == "Stop" || member == "Cancel") Note(member);
      sd_bus_reply_method_return(call, "");
    }
    sd_bus_flush(bus_);
  }

  void AnswerStart(sd_bus_message* call) {
    const std::string unit = NoteCommand(call);
    std::int64_t uptime_s = 0;
    std::ifstream(folder_ + "/uptime") >> uptime_s;
    const bool skipped = uptime_s > until_s_;
    Note(skipped ? "StartTransientUnit skipped" : "StartTransientUnit");
    sd_bus_reply_method_return(call, "o", kJob);
    std::string result = skipped ? "done" : "";  // of systemd 248 and newer
    if (!skipped && Has("job")) {
      std::ifstream(folder_ + "/job") >> result;
      std::rename((folder_ + "/started").c_str(), (folder_ + "/unit").c_str());
      SendChange();
    }
    if (result.empty()) return;
    sd_bus_message* signal = nullptr;
    if (sd_bus_message_new_signal(bus_, &signal, "/org/freedesktop/systemd1",
                                  "org.freedesktop.systemd1.Manager", "JobRemoved") < 0) {
      return;
    }
    sd_bus_message_set_sender(signal, "org.freedesktop.systemd1");
    sd_bus_message_append(signal, "uoss", 1U, kJob, unit.c_str(), result.c_str());
    sd_bus_send(bus_, signal, nullptr);
    sd_bus_message_unref(signal);
  }

  void AnswerKill(sd_bus_message* call) {
    const char* whom = nullptr;
    std::int32_t signal = 0;
    sd_bus_message_read(call, "si", &whom, &signal);
    char* id = nullptr;
    sd_bus_path_decode(sd_bus_message_get_path(call), "/org/freedesktop/systemd1/unit", &id);
    const std::string invocation = id == nullptr ? "" : id;
    free(id);  // NOLINT(cppcoreguidelines-no-malloc): sd-bus's
    if (invocation == Read().invocation()) {
      Note("Kill " + std::to_string(signal));
      sd_bus_reply_method_return(call, "");
    } else {
      Note("Kill of another start");
      sd_bus_reply_method_errorf(call, "org.freedesktop.systemd1.NoUnitForInvocationID", "none");
    }
  }

  void AnswerProperties(sd_bus_message* call) {
    path_ = sd_bus_message_get_path(call);
    Note("GetAll", "reads");
    const char* interface = nullptr;
    sd_bus_message_read(call, "s", &interface);
    sd_bus_message* reply = nullptr;
    if (sd_bus_message_new_method_return(call, &reply) < 0) return;
    const Unit unit = Read();
    if (std::string_view(interface).ends_with(".Service")) {
      sd_bus_message_append(reply, "a{sv}", 5, "MainPID", "u", unit.main_pid(), "ExecMainPID", "u",
                            unit.pid, "ExecMainCode", "i", unit.exec_code(), "ExecMainStatus", "i",
                            unit.exit_code, "Environment", "as", 1, unit.variable.c_str());
    } else {
      AppendUnit(reply, unit);
    }
    sd_bus_send(bus_, reply, nullptr);
    sd_bus_message_unref(reply);
  }

  // Its properties as "a{sv}".
  static void AppendUnit(sd_bus_message* message, const Unit& unit) {
    sd_bus_message_open_container(message, 'a', "{sv}");
    sd_bus_message_append(message, "{sv}", "ActiveState", "s", unit.active.c_str());
    std::array<unsigned char, 16> id{};
    const std::string digits = unit.invocation();
    for (std::size_t i = 0; i < id.size(); ++i) {
      id.at(i) = static_cast<unsigned char>(std::stoi(digits.substr(2 * i, 2), nullptr, 16));
    }
    sd_bus_message_open_container(message, 'e', "sv");
    sd_bus_message_append(message, "s", "InvocationID");
    sd_bus_message_open_container(message, 'v', "ay");
    sd_bus_message_append_array(message, 'y', id.data(), id.size());
    for (int level = 0; level < 3; ++level) sd_bus_message_close_container(message);
  }

  void TellChange() {
    if (path_.empty() || !Has("changed")) return;
    SendChange();
    Take("changed");
  }

  void SendChange() {
    const Unit unit = Read();
    for (const bool service : {true, false}) {
      sd_bus_message* signal = nullptr;
      if (sd_bus_message_new_signal(bus_, &signal, path_.c_str(), "org.freedesktop.DBus.Properties",
                                    "PropertiesChanged") < 0) {
        return;
      }
      sd_bus_message_set_sender(signal, "org.freedesktop.systemd1");
      if (service) {
        sd_bus_message_append(signal, "sa{sv}as", "org.freedesktop.systemd1.Service", 5, "MainPID",
                              "u", unit.main_pid(), "ExecMainPID", "u", unit.pid, "ExecMainCode",
                              "i", unit.exec_code(), "ExecMainStatus", "i", unit.exit_code,
                              "Result", "s", unit.result.c_str(), 0);
      } else {
        sd_bus_message_append(signal, "s", "org.freedesktop.systemd1.Unit");
        AppendUnit(signal, unit);
        sd_bus_message_append(signal, "as", 0);
      }
      sd_bus_send(bus_, signal, nullptr);
      sd_bus_message_unref(signal);
    }
    sd_bus_flush(bus_);
  }

  // Notes how the command is given, and its arguments. Returns the name of the unit.
  std::string NoteCommand(sd_bus_message* call) {
    const char* unit = nullptr;
    const char* mode = nullptr;
    sd_bus_message_read(call, "ss", &unit, &mode);
    sd_bus_message_enter_container(call, 'a', "(sv)");
    while (sd_bus_message_enter_container(call, 'r', "sv") > 0) {
      const char* property = nullptr;
      sd_bus_message_read(call, "s", &property);
      const std::string name = property;
      if (name.starts_with("Exec")) {
        std::string words;
        sd_bus_message_enter_container(call, 'v', "a(sasas)");
        sd_bus_message_enter_container(call, 'a', "(sasas)");
        sd_bus_message_enter_container(call, 'r', "sasas");
        const char* program = nullptr;
        sd_bus_message_read(call, "s", &program);
        for (int list = 0; list < 2; ++list) {
          sd_bus_message_enter_container(call, 'a', "s");
          const char* word = nullptr;
          while (sd_bus_message_read(call, "s", &word) > 0) words += std::string(" ") + word;
          sd_bus_message_exit_container(call);
        }
        for (int level = 0; level < 3; ++level) sd_bus_message_exit_container(call);
        Note(name + words);
        constexpr std::string_view kLimit = " -le ";
        const std::size_t limit = words.find(kLimit);
        if (limit != std::string::npos) until_s_ = std::stoll(words.substr(limit + kLimit.size()));
      } else {
        Note(name + ValueOf(call));
      }
      sd_bus_message_exit_container(call);
    }
    return unit;
  }

  // " 64" of a variant with a number, a text or a list of devices; else nothing.
  static std::string ValueOf(sd_bus_message* call) {
    const char* contents = nullptr;
    sd_bus_message_peek_type(call, nullptr, &contents);
    const std::string_view type = contents;
    std::uint64_t whole = 0;
    std::int32_t number = 0;
    const char* text = nullptr;
    if (type == "t" && sd_bus_message_read(call, "v", "t", &whole) > 0) {
      return " " + std::to_string(whole);
    }
    if (type == "i" && sd_bus_message_read(call, "v", "i", &number) > 0) {
      return " " + std::to_string(number);
    }
    if (type == "s" && sd_bus_message_read(call, "v", "s", &text) > 0) {
      return std::string(" ") + text;
    }
    if (type == "h") {  // a file
      int file = -1;
      if (sd_bus_message_read(call, "v", "h", &file) <= 0) return "";
      constexpr std::string_view kPrinted = "printed by the unit\n";
      return write(file, kPrinted.data(), kPrinted.size()) > 0 ? " written" : " not written";
    }
    if (type == "a(ss)") {
      std::string words;
      sd_bus_message_enter_container(call, 'v', "a(ss)");
      sd_bus_message_enter_container(call, 'a', "(ss)");
      const char* access = nullptr;
      while (sd_bus_message_read(call, "(ss)", &text, &access) > 0) {
        words += std::string(" ") + text + " " + access;
      }
      sd_bus_message_exit_container(call);
      sd_bus_message_exit_container(call);
      return words;
    }
    sd_bus_message_skip(call, "v");
    return "";
  }

  Unit Read() const {
    Unit unit;
    std::ifstream(folder_ + "/unit") >> unit.active >> unit.pid >> unit.variable >> unit.result >>
        unit.exit_code;
    return unit;
  }
  bool Has(const std::string& name) const {
    return access((folder_ + "/" + name).c_str(), F_OK) == 0;
  }
  bool Take(const std::string& name) const {
    return std::remove((folder_ + "/" + name).c_str()) == 0;
  }
  void Note(const std::string& line, const std::string& file = "calls") const {
    std::ofstream(folder_ + "/" + file, std::ios::app) << line << "\n";
  }

  static constexpr std::uint64_t kLookEach_us = 5'000;
  static constexpr const char* kJob = "/org/freedesktop/systemd1/job/1";
  const std::string folder_;
  sd_bus* bus_ = nullptr;
  std::string path_;          // of the unit
  std::int64_t until_s_ = 0;  // the limit of the last start
};

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2) return FakeSystemd(argv[1]).Run(STDIN_FILENO, STDOUT_FILENO);
  if (argc != 3) return 2;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  // A test that finds the socket may connect.
  const std::string made = std::string(argv[2]) + ".new";
  std::snprintf(address.sun_path, sizeof(address.sun_path), "%s", made.c_str());
  const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool listens =
      bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 &&
      listen(listener, 4) == 0 && rename(made.c_str(), argv[2]) == 0;
  while (listens) {
    const int connection = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    if (connection < 0) break;
    if (FakeSystemd(argv[1]).Run(connection, connection) != 0) break;
  }
  return 1;
}
