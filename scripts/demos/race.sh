# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: the robot of a race course in a simulated hall. It knows what its three
# cameras see. Two robots drive at once, each in its own hall and DDS domain, and take both ways
# through the course; with --short one robot drives to its first bay. The referee of each hall sees the
# true pose, which no robot knows.

speed=5  # factor of the world's time. On a busy computer time waits for the robot, and is slower

# Of each robot: what the boards of its hall show, the hall's seed, and the order of its zones.
routes=("A-2 right B-1" "A-1 left B-2")
seeds=(4 20)
orders=(
  "START QR_A A2 S1 S2 R1 QR_B B1 B2 L1 S2 S1 A1 START"
  "START QR_A A1 S1 S2 L1 QR_B B2 B1 R1 S2 S1 A2 START")
# The states that a robot goes through, as the README of modules/race lists them.
states=(
  "START START_TO_QRA IN_QR_A QRA_TO_A2 IN_A2 A2_TO_S1 IN_S1 S1_TO_S2 IN_S2 S2_TO_R1 IN_R1 R1_TO_QRB
   IN_QRB QRB_TO_B1 IN_B1 B1_TO_B2 IN_B2 B2_TO_L1 IN_L1 L1_TO_S2 IN_S2_R S2_TO_S1 IN_S1_R S1_TO_A1
   IN_A1 A1_TO_START END"
  "START START_TO_QRA IN_QR_A QRA_TO_A1 IN_A1 A1_TO_S1 IN_S1 S1_TO_S2 IN_S2 S2_TO_L1 IN_L1 L1_TO_QRB
   IN_QRB QRB_TO_B2 IN_B2 B2_TO_B1 IN_B1 B1_TO_R1 IN_R1 R1_TO_S2 IN_S2_R S2_TO_S1 IN_S1_R S1_TO_A2
   IN_A2 A2_TO_START END")
domains=("$ROS_DOMAIN_ID")
robots=(0)

# select ROBOT: the commands that follow are for this one.
select_robot() {
  robot=$1
  ROS_DOMAIN_ID=${domains[robot]}
  XDG_STATE_HOME=$scratch/state$robot
  files=$scratch/robot$robot
  journal=$XDG_STATE_HOME/musher/race.domain$ROS_DOMAIN_ID/journal.sqlite
  logs=$XDG_STATE_HOME/musher/race.domain$ROS_DOMAIN_ID/logs
  export ROS_DOMAIN_ID XDG_STATE_HOME
}

# behavior FILTER: the status of the race.
behavior() {
  musher behavior race --history 100 --json 2> /dev/null | jq -r "$1"
}
# state_within SECONDS STATE...: waits until the race is in one of the states; prints its state.
state_within() {
  local until=$((SECONDS + $1)) state
  shift
  while true; do
    state=$(behavior .state)
    [[ " $* " == *" $state "* ]] && break
    ((SECONDS >= until)) && break
    sleep 0.5
  done
  echo "$state"
}
# referee FILTER: from the referee's report.
referee() {
  jq -r "$1" <<< "$report"
}

# The files of a robot: all of config/, with the hall of its route, a recording of the race, timeouts of
# the body and the odometry that are scaled by the speed of the world, time for a self-check on a busy computer,
# and two seconds instead of a minute where it only waits. The boards of this hall have codes: to search them for
# letters, too, would take half a second each time.
make_files() {
  local qr_a arrow qr_b
  read -r qr_a arrow qr_b <<< "${routes[robot]}"
  cp -r "$scratch/config" "$files"
  sed -i -e "s/^seed = 1$/seed = ${seeds[robot]}\nspeed = $speed.0\nlockstep = true/" \
    -e "0,/^\[follows/s/^\[follows/[chosen]\nqr_a = \"$qr_a\"\narrow = \"$arrow\"\nqr_b = \"$qr_b\"\n\n[follows/" \
    -e '0,/^\[camera\.front\]/s/^\[camera\.front\]/[cameras]\nlate = "wait"\n\n[camera.front]/' \
    "$files/scenes/course.toml"
  sed -i -e "s/^record = \"\" /record = \"race.record\" /" \
    -e "/^\[body\]/,/^\[/s/^silent_ms = 2000 /silent_ms = $((2000 * speed)) /" \
    -e "s/^refused_ms = 1000 /refused_ms = $((1000 * speed)) /" \
    -e "s/^fresh_ms = 300 /fresh_ms = $((300 * speed)) /" -e "s/^time_ms = 60000$/time_ms = 2000/" \
    "$files/race/course.toml"
  sed -i "/^\[actuator\.vision\]/,/^times/s/20000/60000/" "$files/race.toml"
  sed -i -e "s/^self_check_ms = 5000 /self_check_ms = 50000 /" -e "s/^letters = true /letters = false /" \
    "$files/vision/course.toml"
  sed -i -e "s/^silent_ms = 500 /silent_ms = $((500 * speed)) /" \
    -e "s/^feedback_ms = 200 /feedback_ms = $((200 * speed)) /" "$files/motion/motion_manager.toml"
  put_board_on_lcm "$files" "$files/scenes/course.toml"
}

boot() {
  step "A robot with three cameras boots in a hall: ${routes[robot]}, seed ${seeds[robot]}"
  make_files
  say "\$ musher up --detach config/race.toml"
  musher_up "$files/race.toml" > "$scratch/up$robot.log" 2>&1
  expect "exit code of up" 0 $?
  expect "the machine" Active "$(status .state)"
  expect "actuators in Active" 8 "$(status '[.actuators[] | select(.state == "Active")] | length')"
  expect_board "$logs/world.log"
}

# A picture of the three cameras in each state.
film() {
  say "\$ musher-camera strip image_left … --beside image_rgb --beside image_right --changes race/behavior_state"
  musher-camera --clock topic strip image_left "$pictures/race-saw.jpg" --beside image_rgb \
    --beside image_right --changes race/behavior_state --on-demand --every 0.6 --count 40 \
    --columns 3 --width 160 > "$scratch/film.log" 2>&1 &
  film=$!
}

begin() {
  step "An unknown command changes nothing; START begins the race"
  shown musher-race send FLY
  expect "it is refused" yes "$(await_line "no command 'FLY'")"
  expect "the state" START "$(behavior .state)"
  shown musher-race send START
  expect "it begins: exit code" 0 "$code"
  expect "the state" START_TO_QRA "$(state_within 20 START_TO_QRA)"
}
# await_line TEXT: waits up to ten seconds until the race has logged the text; prints "yes".
await_line() {
  local _
  for _ in {1..100}; do
    grep -qF "$1" "$logs/race.log" && echo yes && return
    sleep 0.1
  done
}

# At the speed of real time: a restart takes as long as on a robot. The race walks on meanwhile, and the
# next look at the lines waits for a picture.
lose_sight() {
  local process
  step "Its vision module is killed on the way: it is restarted, and the race continues"
  expect "the state" "${1}" "$(state_within 400 "$1" ERROR)"
  shown musher-world send speed 1
  process=$(status .actuators.vision.pid)
  say "\$ kill -KILL $process  # vision"
  kill -KILL "$process"
  await ".actuators.vision | .pid > 0 and .pid != $process and .state == \"Active\""
  expect "vision has a new process, in" Active \
    "$(status ".actuators.vision | if .pid > 0 and .pid != $process then .state else \"none\" end")"
  expect "the machine" Active "$(status .state)"
  expect "the race runs" true "$(behavior '.ticking and .state != "ERROR"')"
  shown musher-world send speed $speed
}

# same_words EXPECTED GOT: how many words of the two are the same, from the first one on.
same_words() {
  local expected got count=0
  read -r -d '' -a expected <<< "$1"
  read -r -d '' -a got <<< "$2"
  while [[ -n ${expected[count]:-} && ${expected[count]} == "${got[count]:-}" ]]; do ((++count)); done
  echo "$count"
}

# It lies down in the bay that its first board names, stands up and goes on.
drive_to_bay() {
  step "It drives by its cameras to its first bay: ${routes[robot]}"
  expect "the state after the bay" A2_TO_S1 "$(state_within 300 A2_TO_S1 ERROR)"
  expect "states that it went through as expected" 6 "$(same_words "${states[robot]}" "$(behavior '.history[].to')")"
  shown musher-world send referee --json
  report=$result
  expect "zones in this order" "START QR_A A2" "$(referee '[.reached[] | select(.in_order) | .zone][:3] | join(" ")')"
  expect "feet that were wholly on a line" 0 "$(referee .lines.whole_foot)"
  expect "collisions" 0 "$(referee .collisions)"
}

drive() {
  local _
  step "It drives by its cameras: ${routes[robot]}"
  expect "the state at the end" END "$(state_within 600 END ERROR)"
  expect "states that it went through as expected" "$(wc -w <<< "${states[robot]}")" \
    "$(same_words "${states[robot]}" "$(behavior '.history[].to')")"
  # END begins with lying down in START, which the referee sees a moment later.
  for _ in {1..10}; do
    report=$(musher-world send referee --json)
    [[ $(referee .finished) == true ]] && break
    sleep 0.2
  done
  say "\$ musher-world send referee"
  expect "the referee: finished" true "$(referee .finished)"
  expect "zones in this order" "${orders[robot]}" \
    "$(referee '[.reached[] | select(.in_order) | .zone] | join(" ")')"
  expect "feet that were wholly on a line" 0 "$(referee .lines.whole_foot)"
  expect "collisions" 0 "$(referee .collisions)"
  say "it took $(referee '.time_s | round') s of world time"
  shown musher-world send draw
  expect "the picture of its way: exit code" 0 "$code"
  [[ -s $result ]] && cp "$result" "$pictures/race-way$((robot + 1)).png"
}

go_home() {
  step "Power-off: TearDown, and all processes exit; the recording is replayed"
  for robot in "${robots[@]}"; do
    select_robot "$robot"
    shown musher down
    expect "exit code" 0 "$code"
  done
  await_end
  for robot in "${robots[@]}"; do
    select_robot "$robot"
    shown musher-race replay "$files/race/race.record" "$files/race/course.toml"
    expect "the replay makes the same changes" "identical" "${result##*: }"
  done
}

end_film() {
  kill -TERM "$film" 2> /dev/null
  wait "$film"
  expect "a strip of pictures: exit code" 0 $?
  say "its pictures are in $pictures/race-saw.jpg, its way in $pictures/race-way1.png"
}

explain_keeping() {
  cat << END

${bold}The robot keeps running.${plain} Commands to try, also from another terminal:

  export PATH=$bin:\$PATH ROS_DOMAIN_ID=$ROS_DOMAIN_ID XDG_STATE_HOME=$XDG_STATE_HOME
  musher-race send RESET && musher-race send START
  musher behavior race --follow
  musher graph --behavior race -o machine.svg
  musher-world send referee
  musher down && rm -r $scratch
END
}

run_short() {
  select_robot 0
  boot
  if ((failures == 0)); then
    begin
    drive_to_bay
  fi
  [[ $keep == yes ]] || go_home
}

run_demo() {
  [[ $short == no ]] || { run_short; return; }
  lock_domain $((ROS_DOMAIN_ID % 100 + 1)) || exit 1
  domains[1]=$domain
  robots=(0 1)
  for robot in "${robots[@]}"; do
    select_robot "$robot"
    boot
  done
  if ((failures == 0)); then
    select_robot 0
    film
    for robot in "${robots[@]}"; do
      select_robot "$robot"
      begin
    done
    select_robot 0
    lose_sight A2_TO_S1
    if ((failures == 0)); then
      for robot in "${robots[@]}"; do
        select_robot "$robot"
        drive
      done
    fi
    end_film
  fi
  [[ $keep == yes ]] || go_home
}
