# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: the competition robot plays its match on a simulated field, once for each side. Then
# everything goes wrong, on each side (with --short on the red one): the dock jams; the mission is killed, hangs and
# is reset in the middle of a climb, while a planner keeps its plan published; an emergency stop, and wheels that are
# stuck, break a climb; a plan leads over a pit; the robot is put on another cell; the arm's server is killed, refuses a
# goal, and is not there at the rack. Each time the robot stands, says why, and goes on by the command that is
# documented. The world counts falls: none.

journal=$XDG_STATE_HOME/musher/meilin.domain$ROS_DOMAIN_ID/journal.sqlite
logs=$XDG_STATE_HOME/musher/meilin.domain$ROS_DOMAIN_ID/logs
planner=''  # a process that keeps a plan published
speed=2  # factor of the world's time. On a busy computer time waits for the robot, and is slower

# Asked again where a busy computer has not found the mission in time.
mission() {
  local text _
  for _ in 1 2 3; do
    text=$(musher-meilin send state --json 2> /dev/null) && break
  done
  jq -r "$1" <<< "$text"
}
field() {
  musher-world send field | jq -r "$1"
}
# await_mission FILTER SECONDS: waits until the filter holds for the state of the match.
await_mission() {
  local end=$((SECONDS + $2))
  while ((SECONDS < end)); do
    [[ $(mission "$1") == true ]] && return
    sleep 0.5
  done
}
# await_field FILTER [SECONDS]: the same for the field; default: a minute.
await_field() {
  local end=$((SECONDS + ${2:-60}))
  while ((SECONDS < end)); do
    [[ $(field "$1") == true ]] && return
    sleep 0.1
  done
}
send_plan() {
  shown musher-meilin send plan "$1"
  say "$result"
}
# A person puts the robot on a cell.
place() {
  shown musher-world send place "$1" "$2" 0
}
standing() {
  expect "bumps and falls" "0 0" "$(field '"\(.bumps) \(.falls)"')"
}

# boot SIDE
boot() {
  step "The $1 robot boots on its field"
  cp "$root/config/scenes/meilin.toml" "$scratch/config/scenes/meilin.toml"
  sed -i "s/^seed = 1$/seed = 1\nspeed = $speed.0\nlockstep = true/; s/^side = \"blue\" .*/side = \"$1\"/" \
    "$scratch/config/scenes/meilin.toml"
  sed -i "s/simulated_[a-z]*[.]json/simulated_$1.json/" "$scratch/config/meilin/mission.toml"
  say "\$ musher up --detach config/meilin.toml"
  musher_up "$scratch/config/meilin.toml" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  expect "actuators in Active" 6 "$(status '[.actuators[] | select(.state == "Active")] | length')"
}

# start [REGION]: the word of a person, without which nothing moves
start() {
  shown musher-meilin start "$@"
  say "$result"
  expect "the start: exit code" 0 "$code"
}

# play SIDE
play() {
  step "The $1 robot takes the spear, docks it, and fetches three boxes over platforms of four heights"
  expect "before the word of a person" WAITING_START "$(mission .state)"
  start full
  await_mission '.state == "WAITING_MF_ACTION_SEQ"' 90
  expect "after the dock" WAITING_MF_ACTION_SEQ "$(mission .state)"
  send_plan "$scratch/config/meilin/plan_$1.toml"
  expect "the plan: exit code" 0 "$code"
  await_mission '.state == "MISSION_SUCCESS" or .state == "MISSION_FAILED"' 150
  expect "the match" "MISSION_SUCCESS: " "$(mission '"\(.state): \(.last_error)"')"
  expect "boxes taken" 3 "$(field '[.events[] | select(.what == "taken")] | length')"
  expect "climbs up and down" "3 2" "$(field '[.events[].what] | "\(map(select(. == "up")) | length) \(
    map(select(. == "down")) | length)"')"
  expect "placed mid and high" "1 1" "$(field '"\(.placed_mid) \(.placed_high)"')"
  expect "bumps and falls" "0 0" "$(field '"\(.bumps) \(.falls)"')"
  musher graph --tree meilin -o "$pictures/meilin-tree-$1.svg" > /dev/null 2>&1
  expect "the tree with its times: exit code" 0 $?
  musher behavior meilin --tree | head -n 40
}

# fails REASON: the match fails, and its reason has this.
fails() {
  await_mission '.state == "MISSION_FAILED"' 120
  expect "the match" MISSION_FAILED "$(mission .state)"
  expect "its reason has '$1'" true "$(mission ".last_error | contains(\"$1\")")"
  say "$(mission .last_error)"
  standing
}

# goes_on [REGION]: to the field, on four short wheels.
goes_on() {
  start "$@"
  await_mission '.state == "WAITING_MF_ACTION_SEQ"' 120
  expect "the match" WAITING_MF_ACTION_SEQ "$(mission .state)"
  expect "its wheels are short" true "$(field '.wheels_mm | max < 70')"
  standing
}

jam_dock() {
  step "The dock jams three times: the match fails, and goes on at the dock"
  start full
  await_field '.spear | .command == 2 and .done'
  shown musher-world send fault "spear stuck"
  fails SpearAction
  shown musher-world send fault none
  goes_on
  expect "docked" true "$(field '[.events[] | select(.what == "docked")] | length >= 1')"
}

lose_arm() {
  step "The arm's server is killed: the match fails with the reason, the robot stands, a new plan goes on"
  local process
  place 1.2 1.2
  # A stuck arm stays busy until it is killed, however slowly this script looks.
  shown musher-world send fault "arm stuck"
  send_plan "$scratch/config/meilin/plan_$1.toml"
  await_field .arm.busy
  expect "the arm is busy" true "$(field .arm.busy)"
  process=$(status .actuators.arm.pid)
  say "\$ kill -KILL $process  # arm"
  kill -KILL "$process"
  fails ArmAction
  shown musher-world send fault none
  await_field '.arm.busy | not'  # it still takes its box, or another one where the robot is put meanwhile
  await ".actuators.arm | .pid > 0 and .pid != $process and .state == \"Active\""
}

refuse_goal() {
  step "The arm is in DeActive and refuses a goal: the match fails with the reason"
  shown musher set DeActive arm
  expect "exit code" 0 "$code"
  plan_file "$1" "[1, 1]" "move = [1, 1]" "fetch = [2, 1]"
  place 2.4 2.4
  send_plan "$scratch/plan.toml"
  expect "the plan: exit code" 0 "$code"
  fails "Goal rejected by arm_action"
  shown musher set Active arm
  expect "exit code" 0 "$code"
}

# plan_file SIDE START STEP...: a drawn plan, $scratch/plan.toml
plan_file() {
  local each
  printf 'side = "%s"\nstart = %s\n' "$1" "$2" > "$scratch/plan.toml"
  shift 2
  for each; do printf '[[step]]\n%s\n' "$each" >> "$scratch/plan.toml"; done
}

# climb SIDE [OPTION]: to the middle of a climb of 200 mm, to the right
climb() {
  plan_file "$1" "[1, 1]" "move = [1, 1]" "move = [1, 0]"
  place 2.4 2.4
  if [[ ${2:-} == --keep ]]; then
    say "\$ musher-meilin send plan --keep plan.toml  # as a planner, which stays"
    musher-meilin send plan --keep "$scratch/plan.toml" > "$scratch/keep.log" 2>&1 &
    planner=$!
  else
    send_plan "$scratch/plan.toml"
    expect "the plan: exit code" 0 "$code"
  fi
  await_field '.wheels_mm | max > 150'
}

end_planner() {
  [[ -n $planner ]] || return
  kill -INT "$planner"
  wait "$planner" 2> /dev/null
  planner=''
}

# in_climb SIDE TROUBLE [OPTION]: a climb, and a function that breaks it. On a busy computer the climb may be over
# first; then its exit code is not 0, and it is tried again.
in_climb() {
  local tries
  for tries in 1 2 3; do
    climb "$1" "${3:-}"
    "$2" && break
    say "the climb was over before that: once more (after $tries of 3)"
    end_planner
    goes_on meilin
  done
  expect "it was in the middle of the climb" yes "$("$2_hit" && echo yes)"
}

wheels_out() {
  [[ $(field '.wheels_mm | max > 70') == true ]]
}

# restarted PROCESS: another process of the mission stands, and says with what it could go on.
restarted() {
  local end=$((SECONDS + 90))
  while ((SECONDS < end)); do
    [[ $(status ".actuators.meilin | .pid > 0 and .pid != $1 and .state == \"Active\"") == true ]] && break
    sleep 0.2
  done
  await_mission '.state == "WAITING_START"' 30
  expect "the restarted mission" WAITING_START "$(mission .state)"
  say "$(mission '"it could go on with \(.goes_on_with)"')"
}

crash() {
  step "The mission is killed in the middle of a climb: it stands, and comes off the edge on command"
  in_climb "$1" kill_mission --keep
  goes_on meilin
  expect "the plan that is still published is taken again" no \
    "$(grep -q 'a plan that was taken before is not taken again' "$logs/meilin.log" && echo no)"
  end_planner
}
kill_mission() {
  local process
  process=$(status .actuators.meilin.pid)
  say "\$ kill -KILL $process  # meilin"
  kill -KILL "$process"
  restarted "$process"
  wheels_out
}
kill_mission_hit() { wheels_out; }

hang() {
  step "The mission hangs in the middle of a climb: it is restarted, stands, and goes on on command"
  in_climb "$1" stop_mission
  goes_on meilin
}
stop_mission() {
  local process
  process=$(status .actuators.meilin.pid)
  say "\$ kill -STOP $process  # meilin"
  kill -STOP "$process"
  restarted "$process"
  wheels_out
}
stop_mission_hit() { wheels_out; }

reset_climb() {
  step "A reset in the middle of a climb: the robot stands, and comes off the edge on command"
  in_climb "$1" reset_mission
  goes_on meilin
}
reset_mission() {
  shown musher-meilin send reset
  await_mission '.state == "WAITING_START"' 30
  expect "the match" WAITING_START "$(mission .state)"
  wheels_out
}
reset_mission_hit() { wheels_out; }

stop_climb() {
  step "An emergency stop in the middle of a climb: the match fails, and comes off the edge on command"
  in_climb "$1" stop_robot
  fails "segment 2 of 2, move (1, 0): "  # it was halted, or the suspension has ended its goal
  goes_on meilin
}
stop_robot() {
  shown musher estop
  shown musher estop --release
  shown musher set Active
  expect "exit code of set Active" 0 "$code"
  await_mission '.state == "MISSION_FAILED"' 120
  stop_robot_hit
}
stop_robot_hit() {
  [[ $(mission '.last_error | contains("move (1, 0): ")') == true ]]
}

time_out() {
  step "The wheels are stuck in the middle of a climb, which times out: the robot comes off the edge on command"
  in_climb "$1" stick
  fails Timeout  # the message of the suspension
  goes_on meilin
}
stick() {
  shown musher-world send fault "suspension stuck"
  await_mission '.state == "MISSION_FAILED"' 120
  shown musher-world send fault none
  stick_hit
}
stick_hit() {
  [[ $(mission '.last_error | contains("Timeout")') == true ]]
}

pit() {
  step "A plan leads straight over a pit: it is refused, and nothing moves"
  plan_file "$1" "[1, 2]" "move = [1, 2]"
  place 2.4 1.2
  send_plan "$scratch/plan.toml"
  expect "the plan: exit code" 1 "$code"
  expect "the reason" true \
    "$(mission '.refused_plan | contains("crosses (1, 1), which has 200 mm")')"
  standing
}

# finish SIDE THIRD: from another cell than the one that the match remembers. The box of (1, 2) was taken by the arm
# that was killed.
finish() {
  step "A person puts the robot on another cell: its plan is checked and run from there, and the rack fails once"
  place 1.2 2.4
  plan_file "$1" "[0, 1]" "move = [1, 1]" "fetch = [2, 1]" "move = [1, 1]" "move = [2, 1]" "fetch = $2" \
    $'move = [2, 1]\nyaw_deg = 0' "move = [3, 1]" "move = [4, 1]" "move = [5, 1]"
  local before
  before=$(field '[.events[] | select(.what == "taken")] | length')
  send_plan "$scratch/plan.toml"
  expect "the plan: exit code" 0 "$code"
  await_field "([.events[] | select(.what == \"taken\")] | length) >= $before + 2" 200
  shown musher set DeActive arm
  expect "exit code" 0 "$code"
  fails "Goal rejected by arm_action"
  shown musher set Active arm
  expect "exit code" 0 "$code"
  start
  await_mission '.state == "MISSION_SUCCESS" or .state == "MISSION_FAILED"' 150
  expect "the match" "MISSION_SUCCESS: " "$(mission '"\(.state): \(.last_error)"')"
  expect "placed mid and high" "1 1" "$(field '"\(.placed_mid) \(.placed_high)"')"
  standing
}

# break_match SIDE THIRD: everything goes wrong. THIRD: the third box
break_match() {
  local speed=1  # so that a climb is in its middle when this script has seen that it is
  boot "$1"
  jam_dock
  crash "$1"
  hang "$1"
  reset_climb "$1"
  stop_climb "$1"
  time_out "$1"
  pit "$1"
  lose_arm "$1"
  refuse_goal "$1"
  finish "$1" "$2"
}

end() {
  step "Power-off, and a picture of the way"
  shown musher-world send draw
  [[ -s $result ]] && cp "$result" "$pictures/meilin-$1.png"
  shown musher down
  expect "exit code" 0 "$code"
  await_end
}

explain_keeping() {
  cat << END

${bold}The robot keeps running.${plain} Commands to try, also from another terminal:

  export PATH=$bin:\$PATH ROS_DOMAIN_ID=$ROS_DOMAIN_ID XDG_STATE_HOME=$XDG_STATE_HOME
  musher-meilin send state
  musher behavior meilin --tree --follow
  musher-world send field
  musher down && rm -r $scratch
END
}

run_demo() {
  local side sides="blue red"
  [[ $short == yes ]] && sides=red
  for side in $sides; do
    boot "$side"
    ((failures == 0)) && play "$side"
    end "$side"
  done
  # A limit that is over sooner, for what is stuck.
  sed -i -E 's/("dock": \{"timeout_sec":) [0-9]+/\1 6/' \
    "$scratch"/config/meilin/simulated_*.json
  for side in $sides; do
    ((failures == 0)) || return
    break_match "$side" "$([[ $side == red ]] && echo "[2, 2]" || echo "[2, 0]")"
    [[ $keep == yes && $side == red ]] || end "$side-recovered"
  done
}
