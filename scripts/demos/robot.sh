# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: a day of a robot that walks in a simulated yard. The battery, the cable and
# the finger on its back are told to the world; whatever follows is the robot's own doing.

config=$scratch/config/robot.toml
journal=$XDG_STATE_HOME/musher/robot/journal.sqlite
speed=4  # of the world's time

# shown COMMAND...: shows the command, runs it; what it says goes to `result`, its exit code to `code`.
shown() {
  say "\$ $*"
  result=$("$@" 2>&1)
  code=$?
}
world() {
  shown musher-world tell "$@"
}
motion() {
  shown musher-motion --clock topic --json "$@"
}

boot() {
  act "The robot boots and stands up"
  say "\$ musher up --detach robot.toml"
  musher_up "$config" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  expect "the machine" Active "$(status .state)"
  world speed $speed
  expect "the world's time goes $speed times as fast: exit code" 0 "$code"
  motion result 111
  expect "recovery stand" "true 0" "$(answer '"\(.result) \(.code)"')"
}

walk() {
  act "It walks a square of two metres"
  motion walk --square 2 --speed 0.6
  expect "exit code" 0 "$code"
  at_most "away from where it began" 30 "$(answer '.gap_m * 100 | round')" cm
}

be_protected() {
  act "The battery falls to 18 %: Protected"
  world battery 18
  await '.state == "Protected"'
  expect "the machine" Protected "$(status .state)"
  expect "why" yes "$(musher history --why --journal "$journal" | grep -q '18 %' && echo yes)"
  shown musher capabilities back_flip --json
  expect "a back flip is allowed" false "$(answer .allowed)"
  motion result 121
  expect "a back flip is refused with" "false 3013" "$(answer '"\(.result) \(.code)"')"
  motion servo --id 303 --vx 0.3 --seconds 2
  expect "walking goes on: exit code" 0 "$code"
}

rest() {
  act "The battery falls to 4 %: LowPower"
  world battery 4
  await '.state == "LowPower" and .target == ""'
  expect "the machine" LowPower "$(status .state)"
  motion status
  expect "its motion, 101 being to lie down" 101 "$(answer .motion_id)"
  motion result 111
  expect "standing up is refused with" "false 3003" "$(answer '"\(.result) \(.code)"')"
  motion result 0
  expect "emergency stop is not refused" "true 0" "$(answer '"\(.result) \(.code)"')"
  musher_set Active
  expect "Active is refused with" "refused 113" "$(answer '"\(.outcome) \(.code)"')"
}

charge() {
  act "It is charged: it gets up again by itself, level by level"
  world cable in
  world battery 12
  await '.state == "Protected"'
  expect "the machine at 12 %" Protected "$(status .state)"
  world battery 60
  await '.state == "Active"'
  expect "the machine at 60 %" Active "$(status .state)"
  world cable out
  motion result 111
  expect "recovery stand, which ends the emergency stop" "true 0" \
    "$(answer '"\(.result) \(.code)"')"
}

lie_still() {
  act "It lies still for 30 s: LowPower, until it is woken up"
  motion result 101
  expect "getting down" "true 0" "$(answer '"\(.result) \(.code)"')"
  await '.state == "LowPower"'
  expect "the machine" LowPower "$(status .state)"
  shown musher wake
  expect "exit code of wake" 0 "$code"
  expect "the machine" Active "$(status .state)"
}

keep_state() {
  act "It is kept in Active, whatever the battery says"
  shown musher keep Active --for 600
  expect "exit code of keep" 0 "$code"
  world battery 4
  shown musher poweroff
  expect "power-off is refused: exit code" 1 "$code"
  motion result 111
  expect "standing up at 4 %" "true 0" "$(answer '"\(.result) \(.code)"')"
  expect "the machine" Active "$(status .state)"
  shown musher keep --end
  await '.state == "LowPower"'
  expect "the machine after the keep" LowPower "$(status .state)"
}

power_off() {
  act "Power-off: TearDown, and everything ends"
  world draw
  expect "the picture of the day: exit code" 0 "$code"
  [[ -s $result ]] && cp "$result" "$picture" && say "the picture is in $picture"
  shown musher poweroff
  expect "exit code" 0 "$code"
  await_end
  expect "the last thing on record" "power-off; no command is configured" \
    "$(history_of '.[-1].message')"
}

explain_keeping() {
  cat << END

${bold}The robot stays up.${plain} To play with it, from another terminal too:

  export PATH=$bin:\$PATH ROS_DOMAIN_ID=$ROS_DOMAIN_ID XDG_STATE_HOME=$XDG_STATE_HOME
  musher status --watch
  musher capabilities
  musher-world tell battery 60
  musher-motion result 111 && musher-motion walk --square 1
  musher-world tell draw
  musher down && rm -r $scratch
END
}

play() {
  boot
  if ((failures == 0)); then
    walk
    be_protected
    rest
    charge
    lie_still
    keep_state
  fi
  [[ $keep == yes ]] || power_off
}
