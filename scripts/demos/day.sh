# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: a day of a robot, in a simulated yard. The script sets the battery, the cable
# and the touch sensor in the world, and provides upgrades in a folder; the robot reacts by itself.

root_of_robot=$scratch/robot  # with its versions
journal=$XDG_STATE_HOME/musher/robot.domain$ROS_DOMAIN_ID/journal.sqlite
logs=$XDG_STATE_HOME/musher/robot.domain$ROS_DOMAIN_ID/logs
picture=$pictures/robot-day.png strip=$pictures/robot-saw.jpg
speed=4  # factor of the world's time
walking_speed=2  # the same during a walk, which the tool controls twenty times a second

world() {
  shown musher-world send "$@"
}
motion() {
  shown musher-motion --clock topic --json "$@"
}
# ota COMMAND...: prints the command with shortened folders.
ota() {
  say "\$ musher ota ${*//$scratch\//}"
  result=$(musher ota "$@" 2>&1)
  code=$?
}
# has_said TEXT: waits up to a minute until the robot has said the text since its audio module was started.
has_said() {
  local _
  for _ in {1..300}; do
    grep -q "plays \"$1" "$logs/audio.log" && echo yes && return
    sleep 0.2
  done
}

# The yard is not part of the robot: it keeps running when the robot is upgraded or switched off.
make_yard() {
  (cd "$scratch" && MUSHER_DEMO=$scratch exec musher-world config/scenes/yard.toml --alone) \
    > "$scratch/yard.log" 2>&1 &
  yard=$!
}

# The robot's files: all of config/, but without the yard in the state config, and with limits that a busy
# computer keeps, too. Those of the body are of the world's time.
make_versions() {
  local files=$scratch/files
  cp -r "$scratch/config" "$files"
  sed -i -e 's/"world", //' -e '/^after = \["world"\]$/d' -e '/^\[actuator\.world\]$/,/^$/d' \
    -e '/^times = /s/[0-9]\+/&0/g' -e 's/^default_time = .*/&\nshutdown_budget_ms = 60000/' \
    -e 's/^force_after_s = 15 /force_after_s = 120 /' "$files/robot.toml"
  sed -i -e "s/^silent_ms = 500 /silent_ms = $((2000 * speed)) /" \
    -e "s/^feedback_ms = 200 /feedback_ms = $((1000 * speed)) /" "$files/motion/motion_manager.toml"
  sed -i -e 's/^self_check_ms = [35]000 /self_check_ms = 15000 /' \
    "$files/camera/cameras.toml" "$files/device/device_manager.toml" "$files/sensor/sensor_manager.toml"
  put_board_on_lcm "$files" "$scratch/config/scenes/yard.toml"
  musher ota keygen "$scratch/maker" > /dev/null &&
    musher ota bundle "$files" --version 1.0.0 --key "$scratch/maker.key" -o "$scratch/v1.0.0" &&
    sed -i 's/"Good day\. I am awake\."/"Good day. I am awake, and I have learnt something."/' \
      "$files/audio/phrases.toml" &&
    musher ota bundle "$files" --version 1.1.0 --key "$scratch/maker.key" -o "$scratch/v1.1.0" &&
    cp -r "$scratch/v1.1.0" "$scratch/altered" &&
    sed -i 's/awake/asleep/' "$scratch/altered/payload/audio/phrases.toml" &&
    musher ota init "$root_of_robot" --from "$scratch/v1.0.0" --key "$scratch/maker.pub"
}

boot() {
  step "The robot boots, announces that it is ready, and stands up"
  make_versions > "$scratch/versions.log" 2>&1
  expect "the first version is created: exit code" 0 $?
  make_yard
  say "\$ musher up --detach robot"
  musher_up "$root_of_robot" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  expect "the machine" Active "$(status .state)"
  await '.actuators | all(.state == "Active")'
  expect "actuators in Active" 5 "$(status '[.actuators[] | select(.state == "Active")] | length')"
  # Until its scene: between two commands a slow computer may leave the robot lying for 30 s of the world.
  shown musher low-power off
  world speed $speed
  expect "the world runs at $speed times the speed: exit code" 0 "$code"
  motion result 111
  expect "recovery stand" "true 0" "$(answer '"\(.result) \(.code)"')"
  expect_board "$scratch/yard.log"
  expect "it has said its greeting" yes "$(has_said "Good day")"
}

walk() {
  local process films
  step "It walks a square of two metres and takes pictures; a module is killed at the start"
  world speed $walking_speed
  say "\$ musher-camera strip image_rgb …"
  musher-camera --clock topic strip image_rgb "$strip" --every 3 --count 8 --columns 4 \
    > "$scratch/strip.log" 2>&1 &
  films=$!
  process=$(status .actuators.sensor_manager.pid)
  say "\$ kill -KILL $process  # sensor_manager"
  kill -KILL "$process"
  world mark "kill -KILL sensor_manager"
  motion walk --square 2 --speed 0.6
  expect "exit code" 0 "$code"
  at_most "distance from the start" 30 "$(answer '.gap_m * 100 | round')" cm
  world speed $speed
  await '.actuators | all(.state == "Active")'
  expect "sensor_manager has a new process" true \
    "$(status ".actuators.sensor_manager.pid | . > 0 and . != $process")"
  expect "sensor_manager after the restart" Active "$(status .actuators.sensor_manager.state)"
  kill -TERM "$films" 2> /dev/null
  wait "$films"
  expect "the strip of pictures: exit code" 0 $?
  [[ -s $strip ]] && say "its pictures are in $strip"
}

be_protected() {
  step "The battery falls to 18 %: Protected"
  world battery 18
  await '.state == "Protected"'
  expect "the machine" Protected "$(status .state)"
  expect "the cause is in the history" yes "$(musher history --why --journal "$journal" | grep -q '18 %' && echo yes)"
  shown musher capabilities back_flip --json
  expect "a back flip is allowed" false "$(answer .allowed)"
  motion result 121
  expect "a back flip is refused with" "false 3013" "$(answer '"\(.result) \(.code)"')"
  motion servo --id 303 --vx 0.3 --seconds 2
  expect "walking is still allowed: exit code" 0 "$code"
}

rest() {
  step "The battery falls to 4 %: LowPower"
  world battery 4
  await '.state == "LowPower" and .target == null'
  expect "the machine" LowPower "$(status .state)"
  motion status
  expect "its motion (101: lying down)" 101 "$(answer .motion_id)"
  motion result 111
  expect "standing up is refused with" "false 3003" "$(answer '"\(.result) \(.code)"')"
  motion result 0
  expect "an emergency stop is not refused" "true 0" "$(answer '"\(.result) \(.code)"')"
  shown musher-camera shot image_rgb "$scratch/dark.png" --timeout 2
  expect "its cameras are off: exit code of a shot" 1 "$code"
  musher_set Active
  expect "Active is refused with" "refused 113" "$(answer '"\(.outcome) \(.code)"')"
}

charge() {
  step "It is charged: it becomes more active automatically, level by level"
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
  step "It lies still for 30 s: LowPower, until it is woken up"
  motion result 101
  expect "getting down" "true 0" "$(answer '"\(.result) \(.code)"')"
  shown musher low-power on
  await '.state == "LowPower"'
  expect "the machine" LowPower "$(status .state)"
  shown musher wake
  expect "exit code of wake" 0 "$code"
  expect "the machine" Active "$(status .state)"
  shown musher low-power off
}

keep_state() {
  step "It is kept in Active, independent of the battery"
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

refuse_upgrade() {
  step "An altered bundle: refused, and nothing changes"
  ota install "$scratch/altered" --root "$root_of_robot"
  expect "exit code" 1 "$code"
  expect "the altered file is named" yes "$(grep -q phrases.toml <<< "$result" && echo yes)"
  expect "the machine" Active "$(status .state)"
}

upgrade() {
  step "A valid bundle: the robot lies down, is upgraded and checks itself"
  motion result 111
  expect "recovery stand" "true 0" "$(answer '"\(.result) \(.code)"')"
  world mark upgrade to 1.1.0
  ota install "$scratch/v1.1.0" --root "$root_of_robot"
  expect "exit code" 0 "$code"
  expect "the machine" Active "$(status .state)"
  expect "it was in OTA" true "$(history_of 'any(.message | test("Active → OTA"))')"
  ota status --root "$root_of_robot" --json
  expect "its version" 1.1.0 "$(answer '.slots[] | select(.role == "confirmed") | .version')"
  await '.actuators | all(.state == "Active")'
  expect "actuators in Active" 5 "$(status '[.actuators[] | select(.state == "Active")] | length')"
  expect "it says the new greeting" yes "$(has_said "Good day. I am awake, and I have learnt")"
}

power_off() {
  step "Power-off: TearDown, and all processes exit"
  world draw
  expect "the picture of the day: exit code" 0 "$code"
  [[ -s $result ]] && cp "$result" "$picture" && say "the picture is in $picture"
  shown musher poweroff
  expect "exit code" 0 "$code"
  kill "$yard"
  await_end
  expect "the last record" "power-off; no command is configured" \
    "$(history_of '.[-1].message')"
}

explain_keeping() {
  cat << END

${bold}The robot keeps running.${plain} Commands to try, also from another terminal:

  export PATH=$bin:\$PATH ROS_DOMAIN_ID=$ROS_DOMAIN_ID XDG_STATE_HOME=$XDG_STATE_HOME
  musher status --follow
  musher capabilities
  musher-world send battery 60
  musher-motion result 111 && musher-motion walk --square 1
  musher-audio say "Good morning"
  musher-camera shot image_rgb seen.png
  musher-world send draw
  musher down && kill $yard && rm -r $scratch
END
}

run_demo() {
  boot
  if ((failures == 0)); then
    begin_view
    walk
    be_protected
    rest
    charge
    lie_still
    refuse_upgrade
    upgrade
    keep_state
    page_pictures robot timeline cameras
    end_view
  fi
  [[ $keep == yes ]] || power_off
}
