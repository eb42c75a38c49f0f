# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: seven modules, simulated by musher-exec, through a working day with its bad
# moments.

faults=$scratch/faults
mkdir "$faults"
export MUSHER_FAULTS=$faults  # is what config/exec/simulate obeys
config=$scratch/config/cyberdog.toml
sed -i 's/\b120000\b/3000/g; s/\b240000\b/6000/g' "$config"
# One module promises a sign of life so often; its SetUp may be silent for longer.
sed -i '/^\[actuator.audio\]/a checkpoint_ms = 500\ncheckpoint_ms_in = { SetUp = 6000 }' "$config"
journal=$XDG_STATE_HOME/musher/cyberdog.domain$ROS_DOMAIN_ID/journal.sqlite

# fault ACTUATOR.STATE SECONDS CODE MESSAGE: what config/exec/simulate does from now on.
fault() {
  say "fault: in $1 it will say \"$4\" and end with code $3 after $2 s"
  echo "$2 $3 $4" > "$faults/$1"
}
hang() {
  say "fault: in $1 it will hang, deaf to SIGTERM"
  echo "deaf" > "$faults/$1"
}
repair() {
  rm -f "$faults"/*
}

start_up() {
  act "A staged start to Active"
  say "\$ musher up --detach cyberdog.toml"
  musher_up "$config" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  expect "the machine" Active "$(status .state)"
  expect "those of stage 1 that are Active" 4 \
    "$(status '[.actuators[] | select(.stage == 1 and .state == "Active")] | length')"
  await '[.actuators[] | select(.state == "Active")] | length == 7'
  expect "all that are Active, stage 2 having followed" 7 \
    "$(status '[.actuators[] | select(.state == "Active")] | length')"
  expect "in which order" "the machine is Active, starting stage 2" \
    "$(history_of '[.[].message | select(test("^the machine is Active|^starting stage 2"))] | join(", ")')"
}

self_check() {
  act "A self-check that finds what does not work, and says where and why"
  fault sensor_manager.SelfCheck 0 9 "the lidar does not answer"
  musher_set SelfCheck
  expect "exit code" 1 "$code"
  expect "code" 2009 "$(answer .code)"
  expect "which is degraded, no critical code being among its own" sensor_manager \
    "$(answer '.degraded | join(" ")')"
  expect "its reason" "degraded: the lidar does not answer" \
    "$(answer .actuators.sensor_manager.message)"
  expect "those that go on, it among them" 7 \
    "$(answer '[.actuators[] | select(.outcome == "done")] | length')"
  repair
  musher_set SelfCheck
  expect "once repaired" "done" "$(answer .outcome)"
}

roll_back() {
  act "A switch that fails half-way and is rolled back"
  musher_set DeActive
  expect "outcome" "done" "$(answer .outcome)"
  fault algorithm_manager.Active 0 1 "the model file is damaged"
  musher_set Active
  expect "exit code" 1 "$code"
  expect "outcome" undone "$(answer .outcome)"
  expect "who failed, with which code" "algorithm_manager 4201" \
    "$(answer '.actuators | to_entries[] | select(.value.outcome == "failed") | "\(.key) \(.value.code)"')"
  expect "those that had switched and were brought back" 5 \
    "$(answer '[.actuators[] | select(.outcome == "undone")] | length')"
  expect "the machine" DeActive "$(answer .state)"
  expect "actuators in DeActive" 7 \
    "$(status '[.actuators[] | select(.state == "DeActive")] | length')"
  repair
}

time_out() {
  act "A switch that times out: the actuator is asked, not guessed about"
  hang sensor_manager.Active
  musher_set Active
  expect "exit code" 1 "$code"
  expect "outcome" undone "$(answer .outcome)"
  expect "what became of sensor_manager" "overdue 107" \
    "$(answer '.actuators.sensor_manager | "\(.outcome) \(.code)"')"
  expect "what it said when asked" "still busy with Active" \
    "$(answer '.actuators.sensor_manager.message' | sed 's/ after .*//')"
  repair
  await '.actuators.sensor_manager.state == "DeActive" and .degraded == []'
  expect "where it is now" DeActive "$(status .actuators.sensor_manager.state)"
  musher_set Active
  expect "the same again, without the fault" "done" "$(answer .outcome)"
}

change_modes() {
  act "LowPower, OTA and back"
  local state
  for state in LowPower OTA Active; do
    musher_set $state
    expect "outcome" "done in $state" "$(answer '"\(.outcome) in \(.state)"')"
    expect "actuators there" 7 "$(answer '[.actuators[] | select(.state == "'$state'")] | length')"
  done
}

lose_a_module() {
  act "A module is killed: seen at once, restarted, and back in its place"
  local pid killed ended
  pid=$(status .actuators.vp_engine.pid)
  say "\$ kill -KILL $pid    # vp_engine"
  killed=$(date +%s%3N)
  ((pid > 1)) && kill -KILL "$pid"  # 0, where there is none, would be this script itself
  await ".actuators.vp_engine | .pid > 0 and .pid != $pid and .state == \"Active\" and (.degraded | not)"
  ended='[.[] | select(.actuator == "vp_engine" and (.message | test(" ended: ")))][0]'
  at_most "known after" 1000 \
    "$(($(date -d "$(history_of "$ended.time")" +%s%3N) - killed))" ms
  expect "what is known" "killed by SIGKILL" "$(history_of "$ended.message" | sed 's/.*: //')"
  expect "how often it was restarted" 1 "$(status .actuators.vp_engine.restarts)"
  expect "it was checked and driven to where the machine is" Active \
    "$(status .actuators.vp_engine.state)"
}

freeze_a_module() {
  act "A module freezes: found hung, its backtrace kept, killed, restarted"
  local pid
  pid=$(status .actuators.audio.pid)
  say "\$ kill -STOP $pid    # audio, which promises a sign of life every 500 ms"
  ((pid > 1)) && kill -STOP "$pid"
  await ".actuators.audio | .pid > 0 and .pid != $pid and .state == \"Active\" and (.degraded | not)"
  expect "what is known" "hung: its process is stopped" \
    "$(history_of '[.[].message | select(test("^audio is degraded: hung"))][-1]' | sed 's/.*degraded: //; s/;.*//')"
  expect "a backtrace was taken" yes \
    "$(history_of '[.[].message | select(test("backtrace of audio"))] | if length > 0 then "yes" else "no" end')"
  expect "where it is now" Active "$(status .actuators.audio.state)"
  expect "others that were restarted meanwhile" 0 \
    "$(status '[.actuators | to_entries[] | select(.key != "audio" and .key != "vp_engine" and .value.restarts > 0)] | length')"
}

# A module that needs little gets it from the scheduler beside any number of busy loops. What can
# starve it is one with real-time priority on the only processor that it may use.
starve_a_module() {
  act "A module is starved of CPU: said so, and left alone"
  local pid hog
  pid=$(status .actuators.audio.pid)
  if ((pid <= 1)) || ! chrt --fifo 1 true 2> /dev/null || ! command -v taskset > /dev/null; then
    say "skipped: it takes chrt, taskset, and the right to use real-time priorities"
    return
  fi
  say "\$ taskset -acp 0 $pid; chrt --fifo 1 taskset -c 0 busy_loop &    # audio has 5 % of processor 0"
  taskset -acp 0 "$pid" > /dev/null 2>&1
  chrt --fifo 1 taskset -c 0 bash -c 'while :; do :; done' &
  hog=$!
  await '.actuators.audio.health == "starved"'
  expect "its health" starved "$(status .actuators.audio.health)"
  kill -KILL "$hog" 2> /dev/null
  wait "$hog" 2> /dev/null
  await '.actuators.audio.health == "well"'
  expect "once it gets its share again" well "$(status .actuators.audio.health)"
  expect "its process" "$pid" "$(status .actuators.audio.pid)"
  taskset -acp 0-$(($(nproc) - 1)) "$pid" > /dev/null 2>&1
}

lose_the_controller() {
  act "The controller is killed in the middle of a switch"
  local pids controller
  pids=$(status '[.actuators[].pid] | join(" ")')
  controller=$(status .pid)
  fault device_manager.LowPower 3 0 ""
  say "\$ musher set LowPower &    # and while device_manager is on its way there …"
  musher set LowPower --timeout 5 > /dev/null 2>&1 &
  await '.actuators.device_manager.target == "LowPower"'
  say "\$ kill -KILL $controller    # the controller"
  ((controller > 1)) && kill -KILL "$controller"
  say "\$ musher up --detach cyberdog.toml"
  musher_up "$config" > "$scratch/up2.log" 2>&1
  expect "exit code of the next up" 0 $?
  await '[.actuators[] | select(.state == "LowPower")] | length == 7'
  expect "the switch is finished: modules in LowPower" 7 \
    "$(status '[.actuators[] | select(.state == "LowPower")] | length')"
  expect "the machine" LowPower "$(status .state)"
  expect "processes are the same as before" "$pids" "$(status '[.actuators[].pid] | join(" ")')"
  expect "and the journal says so" yes \
    "$(history_of '[.[].message | select(test("left a switch unfinished"))] | if length > 0 then "yes" else "no" end')"
  repair
  musher_set Active
  expect "outcome" "done" "$(answer .outcome)"
}

start_a_rival() {
  act "A second controller: refused, unless it is told to take over"
  local pids first
  pids=$(status '[.actuators[].pid] | join(" ")')
  first=$(status .pid)
  say "\$ musher up --detach cyberdog.toml"
  musher_up "$config" > "$scratch/rival.log" 2>&1
  expect "exit code" 2 $?
  expect "it names the living one" yes "$(grep -q "process $first" "$scratch/rival.log" && echo yes)"
  say "\$ musher up --detach --takeover cyberdog.toml"
  musher_up --takeover "$config" > "$scratch/takeover.log" 2>&1
  expect "exit code" 0 $?
  expect "another controller leads" yes \
    "$([[ $(status .pid) != "$first" && $(status .pid) -gt 1 ]] && echo yes)"
  expect "in the same state, with the same processes" "Active $pids" \
    "$(status '"\(.state) \([.actuators[].pid] | join(" "))"')"
}

stop_all() {
  act "An emergency stop: latched by every module until a person releases it"
  say "\$ musher estop smoke"
  result=$(musher estop smoke --json 2> /dev/null)
  code=$?
  expect "exit code" 0 "$code"
  expect "modules that have stopped" 7 \
    "$(answer '[.actuators[] | select(.stopped)] | length')"
  musher_set DeActive
  expect "down is allowed" "done" "$(answer .outcome)"
  musher_set Active
  expect "up is not" "refused 113" "$(answer '"\(.outcome) \(.code)"')"
  say "\$ musher estop --release"
  musher estop --release > /dev/null 2>&1
  expect "released, and nothing has moved" "false DeActive" \
    "$(status '"\(.emergency_stop.engaged) \(.state)"')"
  musher_set Active
  expect "outcome" "done" "$(answer .outcome)"
}

tear_down() {
  act "TearDown in reverse order"
  say "\$ musher down"
  result=$(musher down --json --timeout 20 2> /dev/null)
  expect "exit code" 0 $?
  expect "outcome" "done" "$(answer .outcome)"
  local order
  order=$(history_of '[.[] | select(.message | test(": TearDown done")).actuator] | join(" ")')
  expect "how many were torn down" 7 "$(wc -w <<< "$order")"
  local pair
  for pair in "vp_engine algorithm_manager" "algorithm_manager RealSenseActuator" \
    "RealSenseActuator sensor_manager" "sensor_manager device_manager"; do
    expect "first ${pair% *}, then ${pair#* }" "$pair" \
      "$(tr ' ' '\n' <<< "$order" | grep -xE "${pair/ /|}" | paste -sd' ')"
  done
  await_end
}

explain_keeping() {
  cat << END

${bold}The robot stays up.${plain} To play with it, from another terminal too:

  export PATH=$bin:\$PATH ROS_DOMAIN_ID=$ROS_DOMAIN_ID XDG_STATE_HOME=$XDG_STATE_HOME
  musher status --watch
  musher plan LowPower
  musher set LowPower
  echo '0 9 no voice' > $faults/audio.SelfCheck   # a fault: seconds, code, message
  musher set SelfCheck
  musher history
  musher down && rm -r $scratch
END
}

play() {
  start_up
  if ((failures == 0)); then
    self_check
    roll_back
    time_out
    change_modes
    lose_a_module
    freeze_a_module
    starve_a_module
    lose_the_controller
    start_a_rival
    stop_all
  fi
  [[ $keep == yes ]] || tear_down
}
