// musher-record: records topics into MCAP files and publishes them again. See docs/record.md.

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <exception>

#include "musher/base/usage_error.hpp"
#include "musher/base/version.hpp"
#include "musher/view/record/commands.hpp"

namespace musher::view {
namespace {

void AddWhere(CLI::App& app, DomainOptions& where) {
  const char* name_space = std::getenv("MUSHER_NAMESPACE");  // NOLINT(concurrency-mt-unsafe)
  if (name_space != nullptr) where.name_space = name_space;
  if (where.name_space.starts_with('/')) where.name_space.erase(0, 1);
  app.add_option("--namespace", where.name_space,
                 "Namespace of the machine; default $MUSHER_NAMESPACE, else none")
      ->transform(
          [](const std::string& text) { return text.substr(text.starts_with('/') ? 1 : 0); });
  app.add_option("--domain", where.domain, "DDS domain; default $ROS_DOMAIN_ID, else 0")
      ->check(CLI::Range(0, 232).description(""));
}

void AddRecord(CLI::App& main, RecordOptions& options, int& exit) {
  CLI::App* app = main.add_subcommand("record", "Record topics and the journal into an MCAP file");
  app->add_option("-o,--output", options.output,
                  "The file, which must not exist; default: a name of the time.\n"
                  "With --ring a folder");
  app->add_option("--topic", options.topics,
                  "Only topics of this pattern (*, ?); may be repeated; default all");
  app->add_option("--exclude", options.exclude, "Not topics of this pattern; may be repeated");
  app->add_option("--compression", options.compression, "lz4 (default), zstd or none")
      ->check(CLI::IsMember({"lz4", "zstd", "none"}).description(""));
  app->add_option("--duration", options.duration, "End after this time: 90s, 10m, 2h");
  app->add_option("--max-size", options.max_size, "End when the file has this size: 500M, 2G");
  CLI::Option* max_size = app->get_option("--max-size");
  CLI::Option* ring = app->add_option(
      "--ring", options.ring, "Keep only the last time (5m), and what --keep-on says as a file");
  ring->excludes(max_size);
  app->add_option("--keep-on", options.keep_on,
                  "trouble: the time before and 30 s after an emergency stop, an actuator\n"
                  "that crashes, hangs or is lost, a refused or undone switch, degraded, Error")
      ->check(CLI::IsMember({"trouble"}).description(""))
      ->needs(ring);
  app->add_option("--keep", options.keep, "So many files of trouble; default 20")
      ->check(CLI::Range(1, 10'000).description(""))
      ->needs(ring);
  AddWhere(*app, options.where);
  app->callback([&] { exit = RunRecord(options); });
}

void AddPlay(CLI::App& main, PlayCommandOptions& options, int& exit) {
  CLI::App* app = main.add_subcommand("play", "Publish what was recorded, with its timing and QoS");
  app->add_option("FILE", options.file, "An MCAP file")->required();
  app->add_option("--rate", options.rate, "So many times as fast; default 1")
      ->check(CLI::Range(0.001, 1000.0).description(""));
  app->add_flag("--loop", options.loop, "Begin again at the end");
  app->add_option("--start", options.start, "Begin so far into the recording: 90s, 10m");
  app->add_option("--topic", options.topics,
                  "Only topics of this pattern (*, ?); may be repeated; default all");
  app->add_option("--exclude", options.exclude, "Not topics of this pattern; may be repeated");
  app->add_flag("--no-clock", options.no_clock, "Do not publish the recording's time on /clock");
  app->add_option("--remap", options.remap, "FROM:=TO, publish a topic under another name");
  app->add_flag("--machine-topics", options.machine,
                "Also the topics of a machine (musher/...), which a robot would obey");
  app->add_flag("--beside-a-robot", options.beside_a_robot,
                "Also if a controller or an actuator is in the domain: the robot's\n"
                "processes obey what is played, such as /cmd_vel");
  AddWhere(*app, options.where);
  app->callback([&] { exit = RunPlay(options); });
}

int Main(int argc, char** argv) {
  CLI::App app("Records the topics of a robot into MCAP files and publishes them again.",
               "musher-record");
  app.set_version_flag("--version", "musher-record " + std::string(Version()));
  app.require_subcommand(1);
  app.get_formatter()->column_width(28);
  app.footer(
      "Exit codes: 0 done; 1 not done (reason on stderr); 2 usage or a wrong file; 130 "
      "interrupted.");
  int exit = 0;
  RecordOptions record;
  PlayCommandOptions play;
  std::string file;
  std::string out;
  AddRecord(app, record, exit);
  AddPlay(app, play, exit);
  CLI::App* info = app.add_subcommand("info", "Show the topics, times and sizes of a file");
  info->add_option("FILE", file, "An MCAP file")->required();
  info->callback([&] { exit = RunInfo(file); });
  CLI::App* recover = app.add_subcommand("recover", "Write what can be read of a damaged file");
  recover->add_option("FILE", file, "The damaged file")->required();
  recover->add_option("OUT", out, "The new file, which must not exist")->required();
  recover->callback([&] { exit = RunRecover(file, out); });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return EndOfParse(app, e, 2);
  } catch (const std::exception& e) {  // a system resource is exhausted
    return Fail({kCodeFailed, e.what()}, 1);
  }
  return exit;
}

}  // namespace
}  // namespace musher::view

int main(int argc, char** argv) {
  return musher::view::Main(argc, argv);
}
