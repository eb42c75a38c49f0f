# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: seven modules, simulated by musher-exec, in normal operation and under faults.

faults=$scratch/faults
mkdir "$faults"
export MUSHER_FAULTS=$faults  # read by config/exec/simulate
config=$scratch/config/cyberdog.toml
sed -i 's/\b120000\b/3000/g; s/\b240000\b/6000/g' "$config"
# One module has a checkpoint interval; a longer one during SetUp.
sed -i '/^\[actuator.audio\]/a checkpoint_ms = 500\ncheckpoint_ms_in = { SetUp = 6000 }' "$config"
journal=$XDG_STATE_HOME/musher/cyberdog.domain$ROS_DOMAIN_ID/journal.sqlite

# fault ACTUATOR.STATE SECONDS CODE MESSAGE: a fault that config/exec/simulate injects from now on.
fault() {
  say "fault: $1 fails with code $3, \"$4\", after $2 s"
  echo "$2 $3 $4" > "$faults/$1"
}
hang() {
  say "fault: $1 hangs and ignores SIGTERM"
  echo "deaf" > "$faults/$1"
}
repair() {
  rm -f "$faults"/*
}

start_up() {
  step "A staged start to Active"
  say "\$ musher up --detach cyberdog.toml"
  musher_up "$config" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  expect "the machine" Active "$(status .state)"
  expect "actuators of stage 1 in Active" 4 \
    "$(status '[.actuators[] | select(.stage == 1 and .state == "Active")] | length')"
  await '[.actuators[] | select(.state == "Active")] | length == 7'
  expect "actuators in Active after stage 2" 7 \
    "$(status '[.actuators[] | select(.state == "Active")] | length')"
  expect "in which order" "the machine is Active, starting stage 2" \
    "$(history_of '[.[].message | select(test("^the machine is Active|^starting stage 2"))] | join(", ")')"
}

self_check() {
  step "A self-check that detects a fault, with the actuator and the reason"
  fault sensor_manager.SelfCheck 0 9 "the lidar does not answer"
  musher_set SelfCheck
  expect "exit code" 1 "$code"
  expect "code" 2009 "$(answer .code)"
  expect "degraded, since its code is not critical" sensor_manager \
    "$(answer '.degraded | join(" ")')"
  expect "its reason" "degraded: the lidar does not answer" \
    "$(answer .actuators.sensor_manager.message)"
  expect "actuators that have passed, it among them" 7 \
    "$(answer '[.actuators[] | select(.outcome == "done")] | length')"
  repair
  musher_set SelfCheck
  expect "after the repair" "done" "$(answer .outcome)"
}

roll_back() {
  step "A switch that fails half-way and is rolled back"
  musher_set DeActive
  expect "outcome" "done" "$(answer .outcome)"
  fault algorithm_manager.Active 0 1 "the model file is damaged"
  musher_set Active
  expect "exit code" 1 "$code"
  expect "outcome" undone "$(answer .outcome)"
  expect "the failed actuator and its code" "algorithm_manager 4201" \
    "$(answer '.actuators | to_entries[] | select(.value.outcome == "failed") | "\(.key) \(.value.code)"')"
  expect "actuators that had switched and were brought back" 5 \
    "$(answer '[.actuators[] | select(.outcome == "undone")] | length')"
  expect "the machine" DeActive "$(answer .state)"
  expect "actuators in DeActive" 7 \
    "$(status '[.actuators[] | select(.state == "DeActive")] | length')"
  repair
}

time_out() {
  step "A switch that times out: the controller queries the actuator"
  hang sensor_manager.Active
  musher_set Active
  expect "exit code" 1 "$code"
  expect "outcome" undone "$(answer .outcome)"
  expect "the outcome of sensor_manager" "overdue 107" \
    "$(answer '.actuators.sensor_manager | "\(.outcome) \(.code)"')"
  expect "its answer to the query" "still busy with Active" \
    "$(answer '.actuators.sensor_manager.message' | sed 's/ after .*//')"
  repair
  await '.actuators.sensor_manager.state == "DeActive" and .degraded == []'
  expect "its state now" DeActive "$(status .actuators.sensor_manager.state)"
  musher_set Active
  expect "the same again, without the fault" "done" "$(answer .outcome)"
}

change_modes() {
  step "LowPower, OTA and back"
  local state
  for state in LowPower OTA Active; do
    musher_set $state
    expect "outcome" "done in $state" "$(answer '"\(.outcome) in \(.state)"')"
    expect "actuators in it" 7 "$(answer '[.actuators[] | select(.state == "'$state'")] | length')"
  done
}

lose_a_module() {
  step "A module is killed: detected at once, restarted, and back in the machine's state"
  local pid killed ended
  pid=$(status .actuators.vp_engine.pid)
  say "\$ kill -KILL $pid    # vp_engine"
  killed=$(date +%s%3N)
  ((pid > 1)) && kill -KILL "$pid"  # 0, without a process, would be this script itself
  await ".actuators.vp_engine | .pid > 0 and .pid != $pid and .state == \"Active\" and (.degraded | not)"
  ended='[.[] | select(.actuator == "vp_engine" and (.message | test(" ended: ")))][0]'
  at_most "detected after" 1000 \
    "$(($(date -d "$(history_of "$ended.time")" +%s%3N) - killed))" ms
  expect "the recorded cause" "killed by SIGKILL" "$(history_of "$ended.message" | sed 's/.*: //')"
  expect "its restarts" 1 "$(status .actuators.vp_engine.restarts)"
  expect "its state after the self-check" Active \
    "$(status .actuators.vp_engine.state)"
}

freeze_a_module() {
  step "A module freezes: detected as hung, its backtrace recorded, killed, restarted"
  local pid
  pid=$(status .actuators.audio.pid)
  say "\$ kill -STOP $pid    # audio, with a checkpoint_ms of 500"
  ((pid > 1)) && kill -STOP "$pid"
  await ".actuators.audio | .pid > 0 and .pid != $pid and .state == \"Active\" and (.degraded | not)"
  expect "the recorded health" "hung: its process is stopped" \
    "$(history_of '[.[].message | select(test("^audio is degraded: hung"))][-1]' | sed 's/.*degraded: //; s/;.*//')"
  expect "a backtrace was taken" yes \
    "$(history_of '[.[].message | select(test("backtrace of audio"))] | if length > 0 then "yes" else "no" end')"
  expect "where it is now" Active "$(status .actuators.audio.state)"
  expect "other actuators that were restarted" 0 \
    "$(status '[.actuators | to_entries[] | select(.key != "audio" and .key != "vp_engine" and .value.restarts > 0)] | length')"
}

# A module that needs little CPU time gets it beside any number of busy loops. Only a busy loop with
# real-time priority on its only permitted processor can starve it.
starve_a_module() {
  step "A module is starved of CPU: reported, and left alone"
  local pid hog
  pid=$(status .actuators.audio.pid)
  if ((pid <= 1)) || ! chrt --fifo 1 true 2> /dev/null || ! command -v taskset > /dev/null; then
    say "skipped: this needs chrt, taskset, and permission to use real-time priorities"
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
  expect "its health with CPU time again" well "$(status .actuators.audio.health)"
  expect "its process" "$pid" "$(status .actuators.audio.pid)"
  taskset -acp 0-$(($(nproc) - 1)) "$pid" > /dev/null 2>&1
}

lose_the_controller() {
  step "The controller is killed in the middle of a switch"
  local pids controller
  pids=$(status '[.actuators[].pid] | join(" ")')
  controller=$(status .pid)
  fault device_manager.LowPower 3 0 ""
  say "\$ musher set LowPower &    # and while device_manager is switching …"
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

start_a_second_controller() {
  step "A second controller: refused, except with --takeover"
  local pids first
  pids=$(status '[.actuators[].pid] | join(" ")')
  first=$(status .pid)
  say "\$ musher up --detach cyberdog.toml"
  musher_up "$config" > "$scratch/second.log" 2>&1
  expect "exit code" 2 $?
  expect "it names the running one" yes "$(grep -q "process $first" "$scratch/second.log" && echo yes)"
  say "\$ musher up --detach --takeover cyberdog.toml"
  musher_up --takeover "$config" > "$scratch/takeover.log" 2>&1
  expect "exit code" 0 $?
  expect "another controller leads" yes \
    "$([[ $(status .pid) != "$first" && $(status .pid) -gt 1 ]] && echo yes)"
  expect "in the same state, with the same processes" "Active $pids" \
    "$(status '"\(.state) \([.actuators[].pid] | join(" "))"')"
}

stop_all() {
  step "An emergency stop: latched by every module until a person releases it"
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
  expect "released, and no state has changed" "false DeActive" \
    "$(status '"\(.emergency_stop.engaged) \(.state)"')"
  musher_set Active
  expect "outcome" "done" "$(answer .outcome)"
}

tear_down() {
  step "TearDown in reverse order"
  say "\$ musher down"
  result=$(musher down --json --timeout 20 2> /dev/null)
  expect "exit code" 0 $?
  expect "outcome" "done" "$(answer .outcome)"
  local order
  order=$(history_of '[.[] | select(.message | test(": TearDown done")).actuator] | join(" ")')
  expect "actuators that were torn down" 7 "$(wc -w <<< "$order")"
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

${bold}The robot keeps running.${plain} Commands to try, also from another terminal:

  export PATH=$bin:\$PATH ROS_DOMAIN_ID=$ROS_DOMAIN_ID XDG_STATE_HOME=$XDG_STATE_HOME
  musher status --follow
  musher plan LowPower
  musher set LowPower
  echo '0 9 no voice' > $faults/audio.SelfCheck   # a fault: seconds, code, message
  musher set SelfCheck
  musher history
  musher down && rm -r $scratch
END
}

run_demo() {
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
    start_a_second_controller
    stop_all
  fi
  [[ $keep == yes ]] || tear_down
}
