# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: two ground robots, a humanoid and a flyer in simulated rooms. They are given goals
# and a plan, report progress, carry things and can be cancelled. People and a target cross their paths; what
# stands on a path and is not in the map is seen by the scan.
#
# With --long then the held scenes, in worlds of their own: what robots believe is wrong, and what they see keeps them
# from every contact, as the world counts. Row by row of what once went wrong:
#
#   1  a map with the obstacle in the way comes on the way, or while the robot stands before it
#   2  a drive that was slowed down never ended
#   3  localisation jumps, odometry stands, a body is carried behind a wall
#   4  a line that leads into a box
#   5  a flyer whose skill has ended drifts away
#   6  a U of things that the map does not have
#   7  a flyer and a person
#   8  a map of more than 4 million cells
#   9  no room to start; two robots head-on in a corridor

journal=$XDG_STATE_HOME/musher/skills.domain$ROS_DOMAIN_ID/journal.sqlite
logs=$XDG_STATE_HOME/musher/skills.domain$ROS_DOMAIN_ID/logs
explorer='' start=''
picture=$pictures/skills-rooms.png photo=$pictures/skills-photo.png
speed=2  # factor of the world's time. On a busy computer time waits for the robots, and is slower

# run ROBOT SKILL KEY=VALUE...: runs a skill to its end, whose report goes to `result`.
run() {
  local robot=$1
  shift
  say "\$ musher skill run $* --actuator $robot"
  result=$(musher skill run "$@" --actuator "$robot" --json 2> /dev/null)
  code=$?
}
# begin FILE ROBOT SKILL KEY=VALUE...: the same in the background, with the report in a file.
begin() {
  local file=$scratch/$1 robot=$2
  shift 2
  say "\$ musher skill run $* --actuator $robot &"
  musher skill run "$@" --actuator "$robot" --json > "$file" 2> /dev/null &
  begun=$!
}
# ended FILE: waits for the end of what was begun last, and reads its report.
ended() {
  wait "$2"
  code=$?
  result=$(< "$scratch/$1")
}
# expect_end SKILL OUTCOME MESSAGE: of the report in `result`.
expect_end() {
  expect "$1" "$2: $3" "$(answer '"\(.outcome): \(.message)"')"
}
robots() {
  musher-world send robots --json | jq -r "$1"
}
# sent COMMAND...: controls the world, which has to accept it.
sent() {
  shown musher-world send "$@"
  expect "send: exit code" 0 "$code"
}
# pass SECONDS: waits until so much of the world's time has passed, within a minute.
pass() {
  local began passed=no _
  began=$(robots .time_s)
  for _ in {1..600}; do
    passed=$(robots "if .time_s - ${began:-0} >= $1 then \"yes\" else \"no\" end")
    [[ $passed == yes && -n $began ]] && return
    sleep 0.1
  done
  expect "$1 s of the world's time have passed" yes "$passed"
}
# await_message ROBOT SKILL TEXT: waits until the feedback of the skill begins with the text.
await_message() {
  local _ seen
  for _ in {1..100}; do
    seen=$(timeout 3 musher skill watch "$2" --actuator "$1" --json 2> /dev/null | head -n 1 | jq -r .message)
    [[ $seen == "$3"* ]] && return
  done
  expect "$2 says" "$3" "$seen"
}

# position ROBOT: "x y" in m.
position() {
  robots ".robots[] | select(.name == \"$1\") | \"\(.x_m) \(.y_m)\""
}
# airborne ROBOT
airborne() {
  robots ".robots[] | select(.name == \"$1\") | .airborne"
}
# has_moved ROBOT "X Y": whether it is more than half a metre from there.
has_moved() {
  robots ".robots[] | select(.name == \"$1\") |
    if pow(.x_m - ${2% *}; 2) + pow(.y_m - ${2#* }; 2) > 0.25 then \"yes\" else \"no\" end"
}
# await_moved ROBOT "X Y": waits until it has, for 20 s at most.
await_moved() {
  local _
  for _ in {1..200}; do
    [[ $(has_moved "$@") == yes ]] && return
    sleep 0.1
  done
  expect "$1 moves" yes "$(has_moved "$@")"
}

# has_line FILE TEXT
has_line() {
  if grep -qF "$2" "$1"; then echo yes; else echo no; fi
}
# await_line FILE TEXT: waits for a line with the text, for 20 s at most.
await_line() {
  local _
  for _ in {1..200}; do
    [[ $(has_line "$@") == yes ]] && return
    sleep 0.1
  done
}

boot() {
  step "Two ground robots, a humanoid and a flyer boot in simulated rooms"
  pace "$scratch/config/scenes/rooms.toml"
  say "\$ musher up --detach config/skills.toml"
  musher_up "$scratch/config/skills.toml" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  expect "the machine" Active "$(status .state)"
  expect "actuators in Active" 8 "$(status '[.actuators[] | select(.state == "Active")] | length')"
  shown musher skill list --json
  expect "robots that offer skills" "cf2x_0 h1_0 jetbot_0 jetbot_1" "$(answer '.actuators | keys | join(" ")')"
}

explore() {
  step "One robot explores the hall, as long as the others do their work"
  begin explore.json jetbot_1 explore \
    "boundary=[[0.5,2.5],[4.7,2.5],[4.7,8.7],[1.2,8.7],[1.2,5.6],[0.5,5.6]]" \
    "holes=[[[2.2,4.0],[3.0,4.0],[3.0,4.8],[2.2,4.8]]]" lane_width=1.0 robot_radius=0.3
  explorer=$begun
}

carry() {
  step "A robot drives through a door, past a person, picks up a box and carries it into the next room"
  run jetbot_0 pick_up object_prim_path=box_red
  expect "it is too far away" "failed: Too far" "$(answer '"\(.outcome): \(.message[:7])"')"
  run jetbot_0 nav_2d "goal_pos=[10.3,1.2]"
  expect_end nav_2d completed "Reached goal"
  run jetbot_0 pick_up object_prim_path=box_red
  expect_end pick_up completed "Object picked up"
  expect "it holds" box_red "$(robots '.robots[] | select(.name == "jetbot_0") | .holds')"
  # Facing north: the box does not lie in its way back, nor in the way of the humanoid to the table.
  run jetbot_0 nav_2d "goal_pos=[9.0,7.6]" "goal_quat_wxyz=[0.7071,0,0,0.7071]"
  expect_end nav_2d completed "Reached goal"
  run jetbot_0 put_down
  expect_end put_down completed "Object put down"
  expect "it holds" null "$(robots '.robots[] | select(.name == "jetbot_0") | .holds')"
}

fly() {
  step "The flyer takes off, hovers in the wind, flies through a door, takes a photo and lands"
  run cf2x_0 take_off altitude=1.2
  expect_end take_off completed "Reached altitude"
  run cf2x_0 hover altitude=1.2 duration=3
  expect_end hover completed "Hovered"
  local hovered
  hovered=$(position cf2x_0)
  pass 10
  expect "it is in the air" true "$(airborne cf2x_0)"
  expect "without a skill the wind carries it away" no "$(has_moved cf2x_0 "$hovered")"
  run cf2x_0 nav_3d "goal_pos=[6.4,7.0,1.2]"
  expect_end nav_3d completed "Reached goal"
  local taken
  run cf2x_0 take_photo save_path=lab.png
  expect "take_photo" completed "$(answer .outcome)"
  taken=$(answer '.message | sub("Photo saved to "; "")')
  expect "the photo is a PNG file" "PNG" "$(head -c 4 "$taken" | tail -c 3)"
  cp "$taken" "$photo"
  run cf2x_0 land
  expect_end land completed "Landed"
}

plan() {
  step "A plan for three robots: the humanoid takes the cup from the table and puts it down elsewhere"
  say "\$ musher skill plan config/skills/tidy_table.toml"
  result=$(musher skill plan "$scratch/config/skills/tidy_table.toml" --json 2> /dev/null)
  code=$?
  expect "skill plan: exit code" 0 "$code"
  expect "the plan" "completed: All timesteps completed." "$(answer '"\(.outcome): \(.message)"')"
  expect "its skills" "nav_2d detect grasp take_off place land" "$(answer '[.skills[].skill] | join(" ")')"
  expect "the humanoid holds" null "$(robots '.robots[] | select(.name == "h1_0") | .holds')"
  run h1_0 pick_up object_prim_path=cup
  expect_end pick_up completed "Object picked up"
  expect "the humanoid holds" cup "$(robots '.robots[] | select(.name == "h1_0") | .holds')"
  run h1_0 put_down
  expect_end put_down completed "Object put down"
  expect "the humanoid holds" null "$(robots '.robots[] | select(.name == "h1_0") | .holds')"
}

refuse() {
  step "Goals that cannot be reached, and a second one beside the first, are refused with the reason"
  run jetbot_0 nav_2d "goal_pos=[11,8]"
  expect "a goal behind walls: exit code" 1 "$code"
  expect_end nav_2d failed "Planning failed: no path is wide enough for the robot: the goal (11.00, 8.00) or the start is walled in"
  run jetbot_0 nav_2d "goal_pos=[30,2]"
  expect_end "a goal outside the map" failed "Planning failed: the goal (30.00, 2.00) is outside the map"
  start=$(position jetbot_0)
  begin first.json jetbot_0 nav_2d "goal_pos=[7,1.5]"
  first=$begun
  await_message jetbot_0 nav_2d Moving
  run jetbot_0 nav_2d "goal_pos=[7,6]"
  expect "a second goal: exit code" 1 "$code"
  expect "the reason" "nav_2d is running already" "$(answer .message)"
  run jetbot_0 follow_line
  expect "another skill that moves it" "refused: follow_line needs the base, which nav_2d is using" \
    "$(answer '"\(.outcome): \(.message | split(";")[0])"')"
  run jetbot_0 detect target_prim=box_red
  expect "one that does not" completed "$(answer .outcome)"
}

cancel() {
  step "The first goal is cancelled half-way: the robot stands"
  await_moved jetbot_0 "$start"
  shown musher skill cancel nav_2d --actuator jetbot_0
  expect "cancel: exit code" 0 "$code"
  ended first.json "$first"
  expect "the outcome" cancelled "$(answer .outcome)"
  expect "it has driven half a metre and more" yes "$(has_moved jetbot_0 "$start")"
  expect "it has not reached its goal" yes "$(has_moved jetbot_0 "7 1.5")"
  local before
  before=$(position jetbot_0)
  pass 0.5
  expect "it stands at" "$before" "$(position jetbot_0)"
}

pause_one() {
  step "One skill is paused on its way and stays so over a pause of the robot; resumed it arrives"
  start=$(position jetbot_0)
  begin paused.json jetbot_0 nav_2d "goal_pos=[7,1.5]"
  local drive=$begun before
  await_moved jetbot_0 "$start"
  shown musher skill pause nav_2d --actuator jetbot_0
  expect "pause: exit code" 0 "$code"
  pass 1
  before=$(position jetbot_0)
  shown musher skill resume nav_2d --actuator jetbot_1
  expect "resuming a skill that does not run: exit code" 1 "$code"
  shown musher set LowPower
  shown musher set Active
  expect "set Active: exit code" 0 "$code"
  pass 1
  expect "it still stands at" no "$(has_moved jetbot_0 "$before")"
  shown musher skill resume nav_2d --actuator jetbot_0
  expect "resume: exit code" 0 "$code"
  ended paused.json "$drive"
  expect_end nav_2d completed "Reached goal"
}

aim() {
  step "A robot turns to an object before it takes its photo"
  run jetbot_0 take_photo target=box_red save_path=box.png
  expect "take_photo" completed "$(answer .outcome)"
  run jetbot_0 take_photo target=unicorn
  expect_end "of what is not there" failed \
    "Timeout: unicorn is not in sight after 5 s: the place of unicorn is not known"
}

lose_planner() {
  local process run lines=$scratch/planner-lost.txt
  step "The planner is killed while it plans: the skill waits for its successor, and the robot arrives"
  process=$(status .actuators.planner_server.pid)
  say "\$ kill -STOP $process  # planner_server: the plan stays under way"
  kill -STOP "$process"
  say "\$ musher skill run nav_2d goal_pos=[2.0,1.2] --actuator jetbot_0 &"
  musher skill run nav_2d "goal_pos=[2.0,1.2]" --actuator jetbot_0 > "$lines" 2>&1 &
  run=$!
  await_line "$lines" "Planning path..."
  expect "the skill plans" yes "$(has_line "$lines" "Planning path...")"
  say "\$ kill -KILL $process"
  # On a slow computer the controller comes first: a stopped process hangs.
  kill -KILL "$process" 2> /dev/null || say "the controller has killed it already, as it hung"
  wait "$run"
  expect "nav_2d: exit code" 0 $?
  expect "it has waited for it" yes "$(has_line "$lines" "Waiting (")"
  expect "it has arrived" yes "$(has_line "$lines" "Reached goal")"
  await ".actuators.planner_server | .pid > 0 and .pid != $process and .state == \"Active\""
  expect "the machine" Active "$(status .state)"
}

leave_wall() {
  step "A robot that stands 3 cm before a wall has no room to start: it leaves it, and arrives"
  sent place 0.23 1.5 3.14 jetbot_0
  pass 1
  run jetbot_0 nav_2d "goal_pos=[2.0,1.2]" recoveries=
  expect "without recoveries" "failed: Planning failed: the start, the robot's place, has no room" \
    "$(answer '"\(.outcome): \(.message[:58])"')"
  run jetbot_0 nav_2d "goal_pos=[2.0,1.2]"
  expect_end nav_2d completed "Reached goal"
}

carry_away() {
  step "A robot is carried into another room on its way: its drive ends with the reason, and it goes on from there"
  begin carried.json jetbot_0 nav_2d "goal_pos=[7,1.5]"
  local drive=$begun
  await_message jetbot_0 nav_2d Moving
  sent place 8.5 3.4 0 jetbot_0
  ended carried.json "$drive"
  expect_end nav_2d completed "Reached goal"
  expect "the controller says why" yes \
    "$(has_line "$logs/controller_server.log" "the drive has ended: the pose has jumped")"
  expect "collisions" 0 "$(robots '.robots[] | select(.name == "jetbot_0") | .collisions')"
}

end() {
  step "The exploration ends; a picture of all paths; power-off"
  if [[ -n $explorer ]]; then
    ended explore.json "$explorer"
    expect "explore" completed "$(answer .outcome)"
  fi
  shown musher-world send robots
  printf '%s\n' "$result"
  expect "collisions" 0 "$(robots '[.robots[].collisions] | add')"
  shown musher-world send draw
  expect "the picture: exit code" 0 "$code"
  [[ -s $result ]] && cp "$result" "$picture"
  shown musher down
  expect "exit code" 0 "$code"
  await_end
  say "pictures: $picture, $photo"
}

# --- the held scenes --------------------------------------------------------------------------------

# pace FILE: the world of the scene follows its modules, as fast as the first one.
pace() {
  sed -i "s/^seed = 1$/seed = 1\nspeed = $speed.0\nlockstep = true/" "$1"
}
# up_held FILE ACTUATORS: boots the machine of the scenes.
up_held() {
  say "\$ musher up --detach ${1#"$scratch"/}"
  musher_up "$1" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  expect "the machine" Active "$(status .state)"
  expect "actuators in Active" "$2" "$(status '[.actuators[] | select(.state == "Active")] | length')"
}
boot_held() {
  step "The same robots boot in a wide hall in which what they believe is wrong"
  cp "$root/scripts/demos/skills_held.toml" "$scratch/config/scenes/rooms.toml"
  pace "$scratch/config/scenes/rooms.toml"
  sed -i '/^scan = ""/d' "$scratch/config/skills/cf2x_0.toml"  # here the flyer has a scanner
  sed -i 's|^line = ""|line = "jetbot_1/lines"|' "$scratch/config/skills/jetbot_1.toml"
  up_held "$scratch/config/skills.toml" 8
}
down_held() {
  step "$1: what the world has counted; power-off"
  expect "collisions" 0 "$(robots '[.robots[].collisions] | add')"
  shown musher down
  expect "exit code" 0 "$code"
  await_end
}

# place ROBOT X Y YAW: carries it there, and lets it notice.
place() {
  sent place "$2" "$3" "$4" "$1"
  pass 0.5
}
# expect_arrival ROBOT "X Y": it has completed its skill, and the world has it there, without a contact.
expect_arrival() {
  expect_end "$1" completed "Reached goal"
  expect "the world has it there" no "$(has_moved "$1" "$2")"
  expect_no_contact
}
# Each scene counts for itself: the world has counted from its boot on.
expect_no_contact() {
  expect "collisions so far" 0 "$(robots '[.robots[].collisions] | add')"
}
# expect_stand ROBOT: it does not move for a second.
expect_stand() {
  local before
  pass 0.5
  before=$(position "$1")
  pass 0.5
  expect "it stands at" "${before:-a known place}" "$(position "$1")"
}

# expect_on_way ROBOT "X Y": what comes now comes before it is there.
expect_on_way() {
  expect "it is still on its way" yes "$(has_moved "$1" "$2")"
}

# expect_in_time SECONDS BEGAN: of the world's time.
expect_in_time() {
  expect "it has ended within $1 s" true "$(robots ".time_s - $2 < $1")"
}

held_late_map() {
  step "Row 1: on its way to an obstacle the map comes, with the obstacle in it"
  place jetbot_0 2.5 8 0
  start=$(position jetbot_0)
  begin held.json jetbot_0 nav_2d "goal_pos=[9.5,8]"
  local drive=$begun
  await_moved jetbot_0 "$start"
  expect_on_way jetbot_0 "9.5 8"
  sent map objects
  ended held.json "$drive"
  expect_arrival jetbot_0 "9.5 8"
  sent map fixed
  step "Row 1: the same while it stands right before the obstacle"
  place jetbot_0 5.1 8 0
  begin held.json jetbot_0 nav_2d "goal_pos=[9.5,8]"
  drive=$begun
  sent map objects
  ended held.json "$drive"
  expect_arrival jetbot_0 "9.5 8"
  sent map fixed
}

held_person() {
  step "Row 2: a drive that a person slows down still ends, at its goal and in time"
  local began
  began=$(robots .time_s)
  run jetbot_0 nav_2d "goal_pos=[14,8]"
  expect_arrival jetbot_0 "14 8"
  expect_in_time 40 "$began"
}
held_small_jump() {
  step "Row 2: after a jump of the localisation by 1 m, and back, a drive of 8 m ends in time"
  place jetbot_0 2 2 0
  start=$(position jetbot_0)
  local began
  began=$(robots .time_s)
  begin held.json jetbot_0 nav_2d "goal_pos=[10,2]"
  local drive=$begun
  await_moved jetbot_0 "$start"
  expect_on_way jetbot_0 "10 2"
  sent odometry jump 1 0 jetbot_0
  pass 1
  sent odometry right jetbot_0
  ended held.json "$drive"
  expect_arrival jetbot_0 "10 2"
  expect_in_time 40 "$began"
}

# held_odometry WHAT REASON FAULT...: on a drive the odometry has a fault, which ends it with a reason that has this
# text; right again, it goes on.
held_odometry() {
  step "Row 3: $1 on a drive ends it at a stand, with the reason"
  local reason=$2
  shift 2
  place jetbot_0 2 2 0
  start=$(position jetbot_0)
  begin held.json jetbot_0 nav_2d "goal_pos=[10,2]" lost_limit=4 recoveries=
  local drive=$begun
  await_moved jetbot_0 "$start"
  sent odometry "$@" jetbot_0
  ended held.json "$drive"
  expect "the outcome" failed "$(answer .outcome)"
  say "$(answer .message)"
  expect "the reason has '$reason'" true "$(answer ".message | contains(\"$reason\")")"
  expect_stand jetbot_0
  expect_no_contact
  sent odometry right jetbot_0
  run jetbot_0 nav_2d "goal_pos=[10,2]"
  expect_arrival jetbot_0 "10 2"
}
held_carried() {
  step "Row 3: a robot that is carried behind a wall on its way does not drive through it"
  place jetbot_0 6 4.5 0
  start=$(position jetbot_0)
  begin held.json jetbot_0 nav_2d "goal_pos=[10,4.5]"
  local drive=$begun
  await_moved jetbot_0 "$start"
  sent place 13.5 4.5 3.14 jetbot_0
  ended held.json "$drive"
  expect_arrival jetbot_0 "10 4.5"
}

held_line() {
  step "Row 4: a robot on a line stands before the box on it"
  place jetbot_1 23 12 0
  run jetbot_1 follow_line speed=0.5
  expect "the outcome" failed "$(answer .outcome)"
  say "$(answer .message)"
  expect "it names the obstacle" "Blocked for" "$(answer '.message[:11]')"
  expect_stand jetbot_1
  expect_no_contact
}

# expect_hold WHEN: the flyer keeps its place in the wind.
expect_hold() {
  local before
  before=$(position cf2x_0)
  pass 6
  expect "$1 it is carried away" no "$(has_moved cf2x_0 "$before")"
  expect "$1 it is in the air" true "$(airborne cf2x_0)"
}
# begin_hover: in the background, with its process in `begun`.
begin_hover() {
  begin held.json cf2x_0 hover altitude=1.0 duration=25
  await_message cf2x_0 hover Hovering
}
held_flyer_holds() {
  step "Row 5: a flyer holds its place in the wind after each kind of end, in a pause and at an emergency stop"
  local flight
  run cf2x_0 take_off altitude=1.0
  expect_end take_off completed "Reached altitude"
  expect_hold "completed,"
  begin_hover
  flight=$begun
  shown musher skill cancel hover --actuator cf2x_0
  ended held.json "$flight"
  expect "the outcome" cancelled "$(answer .outcome)"
  expect_hold "cancelled,"
  run cf2x_0 nav_3d "goal_pos=[40,13,1]"
  expect "a goal outside the map" failed "$(answer .outcome)"
  expect_hold "failed,"
  begin_hover
  flight=$begun
  shown musher set LowPower
  expect_hold "paused,"
  shown musher set Active
  expect "set Active: exit code" 0 "$code"
  ended held.json "$flight"
  expect_end hover completed "Hovered"
  begin_hover
  flight=$begun
  shown musher estop
  expect "estop: exit code" 0 "$code"
  expect_hold "stopped,"
  shown musher estop --release
  expect "estop --release: exit code" 0 "$code"
  shown musher set Active
  expect "set Active: exit code" 0 "$code"
  ended held.json "$flight"
  say "hover: $(answer '"\(.outcome): \(.message)"')"
  expect "it has ended with a message" true "$(answer '.message | length > 0')"
  expect_hold "after the stop"
  expect_no_contact
}

held_u_trap() {
  step "Row 6: a U trap that the map does not have"
  place jetbot_0 14 8 0
  run jetbot_0 nav_2d "goal_pos=[21.5,8]"
  expect_arrival jetbot_0 "21.5 8"
}

held_flyer_passes() {
  step "Row 7: a flyer passes a person who goes to and fro"
  run cf2x_0 nav_3d "goal_pos=[10,13,1]"
  expect_arrival cf2x_0 "10 13"
  run cf2x_0 land
  expect_end land completed "Landed"
}

held_tight_start() {
  local gap
  for gap in 0.01 0.04; do
    step "Row 9: a start $gap m from a wall"
    place jetbot_0 "$(awk "BEGIN { print 0.2 + $gap }")" 8 3.14
    run jetbot_0 nav_2d "goal_pos=[2.5,8]"
    expect_arrival jetbot_0 "2.5 8"
  done
}
held_head_on() {
  step "Row 9: two robots meet head-on in a corridor"
  place jetbot_0 10.5 2.5 0
  place jetbot_1 21.5 2.5 3.14
  begin held.json jetbot_0 nav_2d "goal_pos=[21.5,2.5]"
  local first=$begun
  begin second.json jetbot_1 nav_2d "goal_pos=[10.5,2.5]"
  local second=$begun
  ended held.json "$first"
  expect_arrival jetbot_0 "21.5 2.5"
  ended second.json "$second"
  expect_arrival jetbot_1 "10.5 2.5"
}
held_whole_hall() {
  step "From one end of the hall to the other"
  run jetbot_0 nav_2d "goal_pos=[2,2]"
  expect_arrival jetbot_0 "2 2"
}

held_large_map() {
  step "Row 8: a robot boots on a map of 108 m x 104 m at 5 cm"
  cp -r "$root/scripts/demos/skills_large" "$scratch/config/large"
  pace "$scratch/config/large/world.toml"
  journal=${journal/skills.domain/skills_large.domain} logs=${logs/skills.domain/skills_large.domain}
  up_held "$scratch/config/large/skills.toml" 4
  ((failures == 0)) || return
  step "Row 8: it plans round a crate that the map does not have"
  run jetbot_0 nav_2d "goal_pos=[100,98]"
  expect_arrival jetbot_0 "100 98"
  step "Row 8: and out of a U trap"
  run jetbot_0 nav_2d "goal_pos=[106,98]"
  expect_arrival jetbot_0 "106 98"
  down_held "The large map"
}

held_scenes() {
  boot_held
  ((failures == 0)) || return
  held_late_map
  held_person
  held_small_jump
  held_odometry "odometry that stands" "its odometry does not change at all" freeze
  held_odometry "a jump of the localisation by 30 m" "is outside the map" jump 30 0
  held_carried
  held_line
  held_flyer_holds
  held_u_trap
  held_flyer_passes
  held_tight_start
  held_whole_hall
  held_head_on
  down_held "Held scenes"
  held_large_map
}

explain_keeping() {
  cat << END

${bold}The robots keep running.${plain} Commands to try, also from another terminal:

  export PATH=$bin:\$PATH ROS_DOMAIN_ID=$ROS_DOMAIN_ID XDG_STATE_HOME=$XDG_STATE_HOME
  musher skill list
  musher skill run nav_2d goal_pos=[7,2] --actuator jetbot_0
  musher skill watch
  musher graph --skill nav_2d --actuator jetbot_0 -o nav_2d.svg
  musher-world send robots
  musher down && rm -r $scratch
END
}

run_demo() {
  boot
  if ((failures == 0)); then
    explore
    carry
    fly
    plan
    refuse
    cancel
    pause_one
    aim
    lose_planner
    leave_wall
    carry_away
  fi
  [[ $keep == yes ]] && return
  end
  if [[ $long == yes ]] && ((failures == 0)); then held_scenes; fi
}
