# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: the competition robot plays its match on a simulated field, once for each side. Then
# the arm's server is killed during a match, refuses a goal, and a climb times out: each time the match fails
# with the reason, and a new plan goes on. The mission is killed and the robot stopped in the middle of a climb: it
# stands until a command, comes off the edge, and goes on.

journal=$XDG_STATE_HOME/musher/meilin.domain$ROS_DOMAIN_ID/journal.sqlite
logs=$XDG_STATE_HOME/musher/meilin.domain$ROS_DOMAIN_ID/logs
speed=2  # factor of the world's time. On a busy computer time waits for the robot, and is slower

mission() {
  musher-meilin send state --json 2> /dev/null | jq -r "$1"
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
send_plan() {
  shown musher-meilin send plan "$1"
  say "$result"
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
  await_mission '.state == "MISSION_FAILED"' 90
  expect "the match" MISSION_FAILED "$(mission .state)"
  expect "its reason has '$1'" true "$(mission ".last_error | contains(\"$1\")")"
  say "$(mission .last_error)"
  expect "bumps and falls" "0 0" "$(field '"\(.bumps) \(.falls)"')"
}

lose_arm() {
  step "The arm's server is killed: the match fails with the reason, the robot stands, a new plan goes on"
  local process
  start full
  await_mission '.state == "WAITING_MF_ACTION_SEQ"' 90
  # A stuck arm stays busy until it is killed, however slowly this script looks.
  shown musher-world send fault "arm stuck"
  send_plan "$scratch/config/meilin/plan_red.toml"
  for _ in {1..600}; do
    [[ $(field .arm.busy) == true ]] && break
    sleep 0.1
  done
  expect "the arm is busy" true "$(field .arm.busy)"
  process=$(status .actuators.arm.pid)
  say "\$ kill -KILL $process  # arm"
  kill -KILL "$process"
  fails ArmAction
  shown musher-world send fault none
  await ".actuators.arm | .pid > 0 and .pid != $process and .state == \"Active\""
}

refuse_goal() {
  step "The arm is in DeActive and refuses a goal: the match fails with the reason"
  shown musher set DeActive arm
  expect "exit code" 0 "$code"
  cat > "$scratch/fetch.toml" << 'END'
side = "red"
start = [0, 2]
[[step]]
move = [0, 1]
[[step]]
move = [1, 1]
[[step]]
fetch = [2, 1]
END
  send_plan "$scratch/fetch.toml"
  expect "the plan: exit code" 0 "$code"
  fails "Goal rejected by arm_action"
  shown musher set Active arm
  expect "exit code" 0 "$code"
}

time_out() {
  step "The wheels are stuck, and a climb times out: the match fails with the reason"
  shown musher-world send fault "suspension stuck"
  cat > "$scratch/climb.toml" << 'END'
side = "red"
start = [1, 1]
[[step]]
move = [2, 1]
END
  send_plan "$scratch/climb.toml"
  expect "the plan: exit code" 0 "$code"
  fails Timeout  # the message of the suspension
  shown musher-world send fault none
}

# await_climb: until the wheels are out
await_climb() {
  for _ in {1..600}; do
    [[ $(field '.wheels_mm | max > 150') == true ]] && break
    sleep 0.1
  done
}

crash() {
  step "The mission is killed in the middle of a climb: it stands, and comes off the edge on command"
  local process
  cat > "$scratch/climb.toml" << 'END'
side = "red"
start = [1, 1]
[[step]]
move = [1, 1]
[[step]]
move = [1, 0]
END
  send_plan "$scratch/climb.toml"
  expect "the plan: exit code" 0 "$code"
  await_climb
  process=$(status .actuators.meilin.pid)
  say "\$ kill -KILL $process  # meilin"
  kill -KILL "$process"
  await ".actuators.meilin | .pid > 0 and .pid != $process and .state == \"Active\""
  await_mission '.state == "WAITING_START"' 30
  expect "the restarted mission" WAITING_START "$(mission .state)"
  await_mission '.can_start | length > 0' 30  # its first pose has come
  say "$(mission '"it could go on with \(.goes_on_with)"')"
  start meilin
  await_mission '.state == "WAITING_MF_ACTION_SEQ"' 120
  expect "off the edge" WAITING_MF_ACTION_SEQ "$(mission .state)"
  expect "its wheels" true "$(field '.wheels_mm | max < 70')"
  expect "bumps and falls" "0 0" "$(field '"\(.bumps) \(.falls)"')"
}

stop_climb() {
  step "An emergency stop in the middle of a climb: the robot comes off the edge, and goes on"
  send_plan "$scratch/climb.toml"
  expect "the plan: exit code" 0 "$code"
  await_climb
  shown musher estop
  shown musher estop --release
  shown musher set Active
  expect "exit code of set Active" 0 "$code"
  await_mission '.state == "MISSION_FAILED"' 30
  say "$(mission .last_error)"
  start meilin
  await_mission '.state == "WAITING_MF_ACTION_SEQ"' 120
  expect "off the edge" WAITING_MF_ACTION_SEQ "$(mission .state)"
  expect "bumps and falls" "0 0" "$(field '"\(.bumps) \(.falls)"')"
}

# The robot may have come off to the upper cell: for the next climb a person puts it back.
back_to_start() {
  shown musher-world send place 2.4 2.4 0
}

recover() {
  step "A new plan goes on"
  cat > "$scratch/recover.toml" << 'END'
side = "red"
start = [1, 1]
[[step]]
move = [1, 1]
[[step]]
fetch = [2, 1]
[[step]]
move = [1, 1]
[[step]]
move = [2, 1]
[[step]]
fetch = [2, 2]
[[step]]
move = [2, 1]
yaw_deg = 0
[[step]]
move = [3, 1]
[[step]]
move = [4, 1]
[[step]]
move = [5, 1]
END
  send_plan "$scratch/recover.toml"
  expect "the plan: exit code" 0 "$code"
  await_mission '.state == "MISSION_SUCCESS" or .state == "MISSION_FAILED"' 150
  expect "the match" "MISSION_SUCCESS: " "$(mission '"\(.state): \(.last_error)"')"
  expect "placed mid and high" "1 1" "$(field '"\(.placed_mid) \(.placed_high)"')"
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
  musher behavior meilin --tree --watch
  musher-world send field
  musher down && rm -r $scratch
END
}

run_demo() {
  local side
  for side in blue red; do
    boot $side
    ((failures == 0)) && play $side
    end $side
  done
  ((failures == 0)) || return
  boot red
  lose_arm
  refuse_goal
  time_out
  crash
  back_to_start
  stop_climb
  back_to_start
  recover
  [[ $keep == yes ]] || end red-recovered
}
