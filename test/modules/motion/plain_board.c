// A motion board that shares no code with Musher: LCM's own library, and the C code that lcm-gen
// makes of the messages. It stands or walks as it is commanded, and lies down after 500 ms without
// a frame. It takes commands as the robot's public locomotion controller does:
//   - of the frames of each control period of 2 ms it reads the newest one, and no other;
//   - a frame of mode -1, or with the count of the last command, is no command; before the first
//     command that count is -1;
//   - from the first motor_ctrl on it ignores all of them.
// It prints "board ready", and a line for each new command and each text of a gait, which it
// accepts if its first line is one of a gait. With SILENT_MS it takes frames for that time before
// its first response.
//
//   plain_board COMMAND_URL RESPONSE_URL LOCALIZATION_URL MODE GAIT [SILENT_MS]

#include <lcm/lcm.h>
#include <math.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "musher_lcm_danger_states_lcmt.h"
#include "musher_lcm_file_recv_lcmt.h"
#include "musher_lcm_file_send_lcmt.h"
#include "musher_lcm_localization_lcmt.h"
#include "musher_lcm_robot_control_cmd_lcmt.h"
#include "musher_lcm_robot_control_response_lcmt.h"

enum { kControlMs = 2, kReportMs = 20, kLieDownMs = 500, kOneSecondMs = 1000 };
enum { kMotorMode = 15 };

static int64_t NowMs(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1000LL + now.tv_nsec / 1000000;
}

struct Board {
  int mode;
  int gait;
  int8_t life_count;  // of the last command
  float speed[3];     // x, y in m/s, yaw in rad/s
  float x;
  float y;
  float yaw;
  int64_t last_frame_ms;
  musher_lcm_robot_control_cmd_lcmt frame;  // the newest of this period
  bool has_frame;
  bool motors;  // are moved by motor_ctrl
  lcm_t* commands;
};

static void OnGait(const lcm_recv_buf_t* buffer, const char* channel,
                   const musher_lcm_file_send_lcmt* file, void* user) {
  const struct Board* board = (const struct Board*)user;
  const char* text = file->data;
  musher_lcm_file_recv_lcmt result = {0};
  (void)buffer;
  (void)channel;
  result.result =
      strncmp(text, "# Gait Def\n", 11) != 0 && strncmp(text, "# Gait Params\n", 14) != 0;
  musher_lcm_file_recv_lcmt_publish(board->commands, "user_gait_result", &result);
  for (const char* c = text; *c != '\0'; ++c) putchar(*c == '\n' ? '|' : *c);
  printf("\n");
  fflush(stdout);
}

static void OnCommand(const lcm_recv_buf_t* buffer, const char* channel,
                      const musher_lcm_robot_control_cmd_lcmt* command, void* user) {
  struct Board* board = (struct Board*)user;
  (void)buffer;
  (void)channel;
  board->frame = *command;
  board->has_frame = true;
}

static void OnMotors(const lcm_recv_buf_t* buffer, const char* channel, void* user) {
  struct Board* board = (struct Board*)user;
  (void)buffer;
  (void)channel;
  if (!board->motors) printf("motor_ctrl: commands are ignored\n");
  fflush(stdout);
  board->motors = true;
  board->mode = kMotorMode;
  board->gait = 0;
  memset(board->speed, 0, sizeof board->speed);
}

static void Control(struct Board* board) {
  const musher_lcm_robot_control_cmd_lcmt* command = &board->frame;
  if (!board->has_frame) return;
  board->has_frame = false;
  board->last_frame_ms = NowMs();
  if (board->motors || command->mode == -1 || command->life_count == board->life_count) return;
  board->life_count = command->life_count;
  board->mode = command->mode;
  board->gait = command->gait_id;
  for (int i = 0; i < 3; ++i) board->speed[i] = board->mode == 11 ? command->vel_des[i] : 0;
  printf("command mode %d gait %d life %d speed %.2f\n", board->mode, board->gait,
         (uint8_t)board->life_count, (double)command->vel_des[0]);
  fflush(stdout);
}

static void Report(struct Board* board, lcm_t* responses, lcm_t* locations) {
  musher_lcm_robot_control_response_lcmt response = {0};
  musher_lcm_localization_lcmt location = {0};
  response.mode = (int8_t)board->mode;
  response.gait_id = (int8_t)board->gait;
  response.contact = 0x0F;
  response.order_process_bar = 100;
  response.switch_status = board->mode == 0 ? 2 : 0;
  musher_lcm_robot_control_response_lcmt_publish(responses, "robot_control_response", &response);
  const float seconds = (float)kReportMs / 1000;
  const float c = cosf(board->yaw);
  const float s = sinf(board->yaw);
  board->x += (board->speed[0] * c - board->speed[1] * s) * seconds;
  board->y += (board->speed[0] * s + board->speed[1] * c) * seconds;
  board->yaw += board->speed[2] * seconds;
  location.xyz[0] = board->x;
  location.xyz[1] = board->y;
  location.rpy[2] = board->yaw;
  location.vBody[0] = board->speed[0];
  location.vBody[1] = board->speed[1];
  location.omegaBody[2] = board->speed[2];
  location.timestamp = NowMs() * 1000000;
  musher_lcm_localization_lcmt_publish(locations, "global_to_robot", &location);
}

static void ReportTemperatures(lcm_t* responses) {
  musher_lcm_danger_states_lcmt states;
  for (int i = 0; i < 12; ++i) states.motor_temperature[i] = 40.0F + (float)i;
  musher_lcm_danger_states_lcmt_publish(responses, "motor_temperature", &states);
}

static void LieDownWithoutFrames(struct Board* board) {
  const bool lost = board->last_frame_ms != 0 && NowMs() - board->last_frame_ms > kLieDownMs;
  if (!lost || board->mode == 7 || board->motors) return;
  board->mode = 7;
  board->gait = 1;
  memset(board->speed, 0, sizeof board->speed);
  printf("no frame: lies down\n");
  fflush(stdout);
}

// Takes what arrives until then.
static void ReceiveUntil(int64_t end_ms, lcm_t* commands, lcm_t* locations) {
  for (;;) {
    struct pollfd readable[2] = {{lcm_get_fileno(commands), POLLIN, 0},
                                 {lcm_get_fileno(locations), POLLIN, 0}};
    const int64_t left_ms = end_ms - NowMs();
    if (poll(readable, 2, (int)(left_ms > 0 ? left_ms : 0)) <= 0) return;
    if (readable[0].revents != 0) lcm_handle(commands);
    if (readable[1].revents != 0) lcm_handle(locations);
  }
}

int main(int argc, char** argv) {
  if (argc != 6 && argc != 7) return 2;
  lcm_t* commands = lcm_create(argv[1]);
  lcm_t* responses = lcm_create(argv[2]);
  lcm_t* locations = lcm_create(argv[3]);
  if (commands == NULL || responses == NULL || locations == NULL) return 1;
  struct Board board = {0};
  board.mode = atoi(argv[4]);
  board.gait = atoi(argv[5]);
  board.life_count = -1;
  board.commands = commands;
  musher_lcm_robot_control_cmd_lcmt_subscribe(commands, "robot_control_cmd", OnCommand, &board);
  musher_lcm_file_send_lcmt_subscribe(commands, "user_gait_file", OnGait, &board);
  lcm_subscribe(locations, "motor_ctrl", OnMotors, &board);
  printf("board ready\n");
  fflush(stdout);
  int64_t next_report_ms = NowMs() + (argc == 7 ? atoi(argv[6]) : 0);
  int64_t next_temperatures_ms = next_report_ms;
  for (;;) {
    ReceiveUntil(NowMs() + kControlMs, commands, locations);
    Control(&board);
    const int64_t now_ms = NowMs();
    if (now_ms >= next_report_ms) {
      LieDownWithoutFrames(&board);
      Report(&board, responses, locations);
      next_report_ms += kReportMs;
    }
    if (now_ms >= next_temperatures_ms) {
      ReportTemperatures(responses);
      next_temperatures_ms += kOneSecondMs;
    }
  }
}
