# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: the wedding robot in a simulated hall. The guests follow the timetable of
# scenes/wedding.toml; the robot reacts to the pictures of its camera.

journal=$XDG_STATE_HOME/musher/wedding.domain$ROS_DOMAIN_ID/journal.sqlite
logs=$XDG_STATE_HOME/musher/wedding.domain$ROS_DOMAIN_ID/logs
strip=$pictures/wedding-saw.jpg hall=$pictures/wedding-show.jpg graph=$pictures/wedding-machine.svg

# behavior FILTER: the status of the application.
behavior() {
  musher behavior wedding --history 64 --json 2> /dev/null | jq -r "$1"
}
# Its changes so far, as "IDLE>TRACKING TRACKING>PHOTO_POSING …".
changes() {
  behavior '[.history[] | "\(.from)>\(.to)"] | join(" ")'
}
# await_change CHANGE [TIMES]: waits up to a minute for the change, or for TIMES of them; prints "yes".
await_change() {
  local _
  for _ in {1..300}; do
    (($(changes | tr ' ' '\n' | grep -cx "$1") >= ${2:-1})) && echo yes && return
    sleep 0.2
  done
}
# photographs N: waits up to ten seconds until N are saved; prints their number.
photographs() {
  local _ saved
  for _ in {1..100}; do
    saved=$(find "$XDG_STATE_HOME/musher/wedding.domain$ROS_DOMAIN_ID/camera" -name '*.jpg' 2> /dev/null | wc -l)
    ((saved >= $1)) && break
    sleep 0.1
  done
  echo "$saved"
}
# has_said TEXT: waits up to a minute until the robot has said the text since its audio module was started.
has_said() {
  local _
  for _ in {1..300}; do
    grep -q "plays \"$1" "$logs/audio.log" && echo yes && return
    sleep 0.2
  done
}

# film TOPIC FILE OPTION...: a picture of the topic after each change of the show's state.
films=()
film() {
  say "\$ musher-camera strip $1 … --changes /wedding/fsm/state ${*:3}"
  musher-camera --clock topic strip "$1" "$2" --changes /wedding/fsm/state --columns 5 \
    "${@:3}" > "$scratch/$1.log" 2>&1 &
  films+=($!)
}

boot() {
  step "The robot boots, checks its camera, its voice and its body, and waits for guests"
  say "\$ musher up --detach config/wedding.toml"
  musher_up "$scratch/config/wedding.toml" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  expect "the machine" Active "$(status .state)"
  expect "actuators in Active" 5 "$(status '[.actuators[] | select(.state == "Active")] | length')"
  film image_rgb "$strip" --every 0.6 --count 15 --width 256
  film image_hall "$hall" --every 1.7 --count 10
}

greet() {
  step "The bride comes, and the robot greets her"
  expect "from IDLE to TRACKING" yes "$(await_change 'IDLE>TRACKING')"
  expect "it has welcomed her" yes "$(has_said "Welcome")"
}

photograph() {
  step "She makes a heart with her hands: a pose, a countdown, a photograph"
  expect "from TRACKING to PHOTO_POSING" yes "$(await_change 'TRACKING>PHOTO_POSING')"
  shown musher graph --behavior wedding -o "$graph"
  expect "its state machine is drawn: exit code" 0 "$code"
  expect "and back to TRACKING" yes "$(await_change 'PHOTO_POSING>TRACKING')"
  expect "photographs" 1 "$(photographs 1)"
}

farewell() {
  step "She leaves, and it waves"
  expect "from TRACKING to FAREWELL" yes "$(await_change 'TRACKING>FAREWELL')"
  expect "and back to IDLE" yes "$(await_change 'FAREWELL>IDLE')"
  expect "it has said goodbye" yes "$(has_said "Goodbye")"
}

be_close() {
  step "The groom is photographed, too; then a child comes too close: it stops at once, and resumes"
  expect "from TRACKING to SAFE_STOP" yes "$(await_change 'TRACKING>SAFE_STOP')"
  expect "photographs" 2 "$(photographs 2)"
  expect "it asks the child to step back" yes "$(has_said "Please step back")"
  expect "from SAFE_STOP to IDLE" yes "$(await_change 'SAFE_STOP>IDLE')"
}

lose_sight() {
  local process
  step "Its vision module is killed while bride and groom stand there: the show continues"
  expect "it looks at them" yes "$(await_change 'IDLE>TRACKING' 5)"
  process=$(status .actuators.vision.pid)
  say "\$ kill -KILL $process  # vision"
  kill -KILL "$process"
  expect "they are photographed" yes "$(await_change 'PHOTO_POSING>TRACKING' 3)"
  await '.actuators | all(.state == "Active")'
  expect "vision has a new process" true \
    "$(status ".actuators.vision.pid | . > 0 and . != $process")"
  expect "photographs" 3 "$(photographs 3)"
}

rest() {
  step "LowPower: it stands straight and its show is paused; Active: it waits for guests again"
  musher_set LowPower
  expect "LowPower" "done" "$(answer .outcome)"
  expect "its show" "paused IDLE" "$(behavior '"\(if .ticking then "runs" else "paused" end) \(.state)"')"
  musher_set Active
  expect "Active" "done" "$(answer .outcome)"
}

go_home() {
  step "Power-off: TearDown, and all processes exit"
  shown musher down
  expect "exit code" 0 "$code"
  await_end
}

show_pictures() {
  local film
  for film in "${films[@]}"; do
    kill -TERM "$film" 2> /dev/null
    wait "$film"
    expect "a strip of pictures: exit code" 0 $?
  done
  say "the show is in $hall, its pictures in $strip, its state machine in $graph"
}

explain_keeping() {
  cat << END

${bold}The robot keeps running.${plain} Commands to try, also from another terminal:

  export PATH=$bin:\$PATH ROS_DOMAIN_ID=$ROS_DOMAIN_ID XDG_STATE_HOME=$XDG_STATE_HOME
  musher behavior wedding --follow
  musher graph --behavior wedding -o machine.svg
  musher-camera shot image_rgb seen.png
  musher down && rm -r $scratch
END
}

run_demo() {
  boot
  if ((failures == 0)); then
    greet
    photograph
    farewell
    be_close
    lose_sight
    rest
  fi
  show_pictures
  [[ $keep == yes ]] || go_home
}
