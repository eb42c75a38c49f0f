# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: the wedding robot in a simulated hall. The guests come by themselves, as
# scenes/wedding.toml has it; what the robot does follows from what it sees through its camera.

journal=$XDG_STATE_HOME/musher/wedding/journal.sqlite
logs=$XDG_STATE_HOME/musher/wedding/logs
strip=$pictures/wedding-show.jpg graph=$pictures/wedding-machine.svg

# shown COMMAND...: shows the command, runs it; what it says goes to `result`, its exit code to `code`.
shown() {
  say "\$ $*"
  result=$("$@" 2>&1)
  code=$?
}
# behavior FILTER: what the application says of itself.
behavior() {
  musher behavior wedding --history 64 --json 2> /dev/null | jq -r "$1"
}
# Its changes so far, as "IDLE>TRACKING TRACKING>PHOTO_POSING …".
changes() {
  behavior '[.history[] | "\(.from)>\(.to)"] | join(" ")'
}
# await_change CHANGE SECONDS: waits for it; "yes" when it came.
await_change() {
  local _
  for ((_ = 0; _ < $2 * 5; ++_)); do
    [[ " $(changes) " == *" $1 "* ]] && echo yes && return
    sleep 0.2
  done
}
# has_said TEXT: whether it has been said since the voice was started.
has_said() {
  grep -q "says \"$1" "$logs/audio.log" && echo yes
}

boot() {
  act "The robot boots, checks its camera, its voice and its body, and waits for guests"
  say "\$ musher up --detach config/wedding.toml"
  musher_up "$scratch/config/wedding.toml" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  expect "the machine" Active "$(status .state)"
  expect "those that are Active" 5 "$(status '[.actuators[] | select(.state == "Active")] | length')"
  musher-camera --clock topic strip image_rgb "$strip" --changes /wedding/fsm/state --every 0.5 \
    --count 12 --columns 4 --timeout 60 > "$scratch/strip.log" 2>&1 &
  films=$!
}

greet() {
  act "A guest comes, and the robot greets her"
  expect "IDLE>TRACKING" yes "$(await_change 'IDLE>TRACKING' 30)"
  expect "it says so" yes "$(has_said "Welcome")"
}

photograph() {
  act "She makes a heart with her hands: a pose, a countdown, a photograph"
  expect "TRACKING>PHOTO_POSING" yes "$(await_change 'TRACKING>PHOTO_POSING' 30)"
  shown musher graph --behavior wedding -o "$graph"
  expect "its machine is drawn: exit code" 0 "$code"
  expect "PHOTO_POSING>TRACKING" yes "$(await_change 'PHOTO_POSING>TRACKING' 30)"
  expect "photographs" yes "$([[ -n $(find "$XDG_STATE_HOME" -name '*.jpg') ]] && echo yes)"
}

be_close() {
  act "A child comes too close: the robot stops at once, and goes on when it has stepped back"
  expect "into SAFE_STOP" yes "$(await_change 'TRACKING>SAFE_STOP' 60)"
  expect "SAFE_STOP>IDLE" yes "$(await_change 'SAFE_STOP>IDLE' 30)"
}

farewell() {
  act "The guests leave, and it waves"
  expect "TRACKING>FAREWELL" yes "$(await_change 'TRACKING>FAREWELL' 60)"
  expect "FAREWELL>IDLE" yes "$(await_change 'FAREWELL>IDLE' 30)"
}

rest() {
  act "LowPower: it stands straight and rests; Active: it goes on"
  musher_set LowPower
  expect "LowPower" "done" "$(answer .outcome)"
  musher_set Active
  expect "Active" "done" "$(answer .outcome)"
}

go_home() {
  act "Power-off: TearDown, and everything ends"
  wait "$films"
  expect "the strip of pictures: exit code" 0 $?
  [[ -s $strip ]] && say "what it saw is in $strip"
  shown musher down
  expect "exit code of down" 0 "$code"
  await_end
}

explain_keeping() {
  cat << END

${bold}The robot stays up.${plain} To play with it, from another terminal too:

  export PATH=$bin:\$PATH ROS_DOMAIN_ID=$ROS_DOMAIN_ID XDG_STATE_HOME=$XDG_STATE_HOME
  musher behavior wedding --watch
  musher graph --behavior wedding -o machine.svg
  musher-camera shot image_rgb seen.png
  musher down && rm -r $scratch
END
}

play() {
  boot
  if ((failures == 0)); then
    greet
    photograph
    be_close
    farewell
    rest
  fi
  [[ $keep == yes ]] || go_home
}
