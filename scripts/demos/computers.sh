# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034  # what scripts/demo sets, and what it uses
# Sourced by scripts/demo: a robot of three computers, which are roots of Debian that boot with their own systemd and
# sshd in containers. A switch joins them. The controller runs on `brain`; once that has lost its power, its standby on
# `motion` leads. MUSHER_BOARD_ROOT=FOLDER keeps the root of Debian, which takes half a minute to make.

[[ $(id -u) == 0 ]] || { echo "demo: computers needs root: it boots three containers and makes networks" >&2; exit 2; }
for program in systemd-nspawn mmdebstrap ssh ssh-keygen; do
  command -v "$program" > /dev/null ||
    { echo "demo: computers needs $program; install it: apt-get install systemd-container mmdebstrap openssh-client" >&2; exit 2; }
done

[[ $keep == no ]] || { echo "demo: computers ends what it has booted: --keep is for the other shows" >&2; exit 2; }

debian=${MUSHER_BOARD_ROOT:-$scratch/root}
disks=$scratch/disks  # a folder for each computer, which has it as $machine
machine=$scratch/machine config=$scratch/machine/robot.toml
journal=$scratch/machine/state/journal.sqlite
picture=$pictures/robot-computers.svg
unset XDG_STATE_HOME
computers="brain motion vision"
slots=$scratch/machine/slots  # the upgrade root of each computer
cut=0  # when the brain has lost its power, in nanoseconds
here=brain  # where the commands of this demo run
mkdir "$machine" "$disks" "$disks/brain" "$disks/motion" "$disks/vision"
declare -A address=([brain]=10.77.9.1 [motion]=10.77.9.2 [vision]=10.77.9.3)
declare -A modules=([brain]="planner voice lamp" [motion]="legs arms neck hands" [vision]="eyes depth map faces")
declare -A deployed=([brain]=lamp [motion]=hands [vision]=eyes)  # the modules whose versions `musher deploy` copies
declare -A network nspawn init  # init: the first process of a computer, once it has booted

# --- the computers --------------------------------------------------------------------------------

make_debian() {
  local library
  # shellcheck disable=SC1091
  [[ -e $debian/etc/ssh ]] || mmdebstrap --quiet --variant=apt \
    --include=systemd,systemd-sysv,dbus,openssh-server,iproute2 "$(. /etc/os-release && echo "$VERSION_CODENAME")" "$debian" || return
  for library in $(ldd "$bin/musher" "$bin/musher-exec" | awk '/=> \// { print $3 }' | sort -u); do
    [[ -e $debian$library ]] || cp --parents -L "$library" "$debian" || return
  done
  ln -sf "$bin/musher" "$debian/usr/local/bin/musher" || return
  ssh-keygen -q -t ed25519 -N '' -f "$machine/key" && mkdir -p "$debian/root/.ssh" && chmod 700 "$debian/root/.ssh" &&
    cp "$machine/key.pub" "$debian/root/.ssh/authorized_keys" &&
    sed "s/^/${address[brain]},${address[motion]},${address[vision]} /" \
      "$debian/etc/ssh/ssh_host_ed25519_key.pub" > "$machine/known_hosts"
}

# holder: a process that has a network of its own; its number goes to `held`.
holder() {
  MUSHER_DEMO=$scratch unshare --net tail -f /dev/null > /dev/null 2>&1 &
  held=$!
  disown
  while [[ $(readlink "/proc/$held/ns/net") == "$(readlink /proc/self/ns/net)" ]]; do sleep 0.05; done
}
in_network() {
  nsenter --target "$1" --net -- "${@:2}"
}

make_networks() {
  local host
  holder
  network[switch]=$held
  in_network "$held" ip link add wires type bridge && in_network "$held" ip link set wires up
  for host in $computers; do
    holder
    network[$host]=$held
    in_network "${network[switch]}" ip link add "$host" type veth peer name eth0 netns "${network[$host]}" &&
      in_network "${network[switch]}" ip link set "$host" master wires up &&
      in_network "${network[$host]}" ip link set lo up &&
      in_network "${network[$host]}" ip address add "${address[$host]}/24" dev eth0 &&
      in_network "${network[$host]}" ip link set eth0 up || return
  done
}

# boot HOST
boot() {
  systemd-nspawn --quiet --directory="$debian" --volatile=overlay --boot --register=no --keep-unit \
    --machine="$1" --network-namespace-path="/proc/${network[$1]}/ns/net" --bind="$disks/$1:$machine" --bind-ro="$bin" \
    < /dev/null > "$scratch/$1.console" 2>&1 &
  nspawn[$1]=$!
  init[$1]=''
}
# power_off HOST: as if its power was cut.
power_off() {
  local pid=${nspawn[$1]:-}
  [[ -n $pid ]] || return 0
  # shellcheck disable=SC2046
  kill -KILL ${init[$1]} $(cat "/proc/$pid/task/$pid/children") 2> /dev/null
  wait "$pid" 2> /dev/null
  nspawn[$1]=''
}
# on HOST COMMAND...
on() {
  in_network "${network[brain]}" ssh -xT -o BatchMode=yes -o ConnectTimeout=2 \
    -o UserKnownHostsFile="$machine/known_hosts" -i "$machine/key" -l root "${address[$1]}" -- "${@:2}" 2> /dev/null
}
await_host() {
  local _ pid=${nspawn[$1]}
  for _ in {1..60}; do
    on "$1" true && break
    sleep 0.5
  done
  # The kernel may leave a child out.
  for _ in {1..60}; do
    read -r "init[$1]" _ < "/proc/$pid/task/$pid/children" && return
    sleep 0.1
  done
}

clean_computers() {
  local host
  for host in $computers; do power_off "$host"; done
  mountpoint -q "$disks/vision" && umount "$disks/vision"
  clean_up
}
trap clean_computers EXIT

musher() {
  nsenter --target "${init[$here]}" --net --pid --mount --uts --ipc --root --wd -- \
    env MUSHER_TRANSPORT=lan "$bin/musher" "$@"
}

# make_version VERSION: of the programs, in the folder of the config on brain.
make_version() {
  local module
  mkdir -p "$disks/brain/bin"
  for module in "${deployed[@]}"; do
    printf '#!/bin/sh\n# version %s\nexec %s/musher-exec "$@"\n' "$1" "$bin" > "$disks/brain/bin/$module"
    chmod 755 "$disks/brain/bin/$module"
  done
}
# The version that each computer would start.
versions() {
  local host
  for host in $computers; do
    on "$host" "sed -n 's/^# version //p' $slots/current/bin/${deployed[$host]}"
  done | paste -s -d ' '
}

make_config() {
  local host module program all=()
  for host in $computers; do
    for module in ${modules[$host]}; do all+=("\"$module\""); done
  done
  {
    printf '[controller]\nname = "robot"\nactuators = [%s]\n' "$(IFS=,; echo "${all[*]}")"
    printf 'states = ["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]\ndefault_time = 2000\nstate_dir = "state"\n'
    # No actuator is critical, so all vote: eight of the eleven are there without the brain, seven without another one.
    printf 'failover_ms = 3000\nunits = "always"\n'
    printf '[transport]\nprofile = "lan"\ninterfaces = ["eth0"]\n'
    for host in $computers; do
      printf '[host.%s]\naddress = "%s"\nuser = "root"\nkey = "key"\nknown_hosts = "known_hosts"\n' "$host" "${address[$host]}"
    done
    for host in $computers; do
      for module in ${modules[$host]}; do
        echo '[state.LowPower]' > "$machine/$module.toml"
        echo 'run = ["true"]' >> "$machine/$module.toml"
        printf '[actuator.%s]\nstates = ["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]\n' "$module"
        program=$bin/musher-exec
        [[ $module != "${deployed[$host]}" ]] || program=$slots/current/bin/$module
        printf 'times = [20000, 5000, 5000, 5000, 5000]\ncommand = ["%s", "%s/%s.toml"]\n' "$program" "$machine" "$module"
        printf 'host = "%s"\n' "$host"
        [[ $module != faces || $limited == no ]] || printf 'memory_max_mb = 64\n'
      done
    done
  } > "$config"
  # What eats memory in LowPower, where its limit is kept.
  [[ $limited == no ]] || echo 'run = ["sh", "-c", "tail -c 200M /dev/zero | tail"]' |
    cat <(echo '[state.LowPower]') - > "$machine/faces.toml"
  for host in $computers; do cp "$machine"/* "$disks/$host"; done
}

# --- the steps ------------------------------------------------------------------------------------

pid_of() {
  status ".actuators.$1.pid"
}
all_active() {
  await '.state == "Active" and ([.actuators[] | select(.state == "Active" and .degraded == false)] | length == 11)'
  expect "actuators in Active" 11 "$(status '[.actuators[] | select(.state == "Active")] | length')"
}
units_on() {
  on "$1" "systemctl list-units --no-legend --state=running 'musher-*'" | wc -l
}

start_up() {
  step "Three computers boot; one of them starts the modules of all"
  make_debian > "$scratch/debian.log" 2>&1
  expect "a root of Debian is made: exit code" 0 $?
  make_networks
  expect "three networks are joined: exit code" 0 $?
  local host
  mount -t tmpfs -o size=64m tmpfs "$disks/vision"
  expect "vision has a small disk: exit code" 0 $?
  for host in $computers; do boot "$host"; done
  for host in $computers; do await_host "$host"; done
  limited=$(on vision grep -qw memory /sys/fs/cgroup/cgroup.controllers && echo yes || echo no)
  make_config
  make_version 1.0.0
  say "\$ musher ota keygen robot"
  musher ota keygen "$machine/robot" > "$scratch/deploy.log" 2>&1
  say "\$ musher deploy robot.toml --version 1.0.0 --key robot.key"
  musher deploy "$config" --version 1.0.0 --key "$machine/robot.key" >> "$scratch/deploy.log" 2>&1
  expect "exit code of deploy" 0 $?
  say "\$ musher check --hosts robot.toml"
  musher check --hosts "$config" > "$scratch/check.log" 2>&1
  expect "exit code of check" 0 $?
  say "\$ musher up --detach robot.toml"
  musher_up "$config" > "$scratch/up.log" 2>&1
  expect "exit code of up" 0 $?
  all_active
  expect "units on brain" 3 "$(units_on brain)"
  expect "units on motion" 4 "$(units_on motion)"
  expect "units on vision" 4 "$(units_on vision)"
}

kill_one() {
  step "A module of another computer is killed, and started again"
  local before after killed seen
  before=$(pid_of eyes)
  say "\$ ssh vision kill -KILL $before    # eyes"
  killed=$(on vision "date +%s%N; kill -KILL $before")
  await ".actuators.eyes.pid != null and .actuators.eyes.pid != $before and .actuators.eyes.state == \"Active\""
  after=$(pid_of eyes)
  expect "it has another process" yes "$([[ $after != "$before" && $after != null ]] && echo yes)"
  seen=$(history_of "[.[] | select(.message == \"eyes's process $before ended: killed by SIGKILL\")][0].time")
  at_most "until the controller knew" 200 "$((($(date -d "$seen" +%s%N) - killed) / 1000000))" ms
  all_active
}

eat_memory() {
  step "A module needs more memory than its limit"
  if [[ $limited == no ]]; then
    say "left out: the containers of this computer have no memory controller in cgroups of version 2"
    return
  fi
  musher_set LowPower
  await '.actuators.faces.restarts >= 1'
  expect "it is named" yes "$(history_of '[.[].message | select(test("out of memory: its limit .memory_max_mb = 64"))] | length > 0' | sed 's/true/yes/')"
  printf '[state.LowPower]\nrun = ["true"]\n' > "$disks/vision/faces.toml"
  musher_set Active
  all_active
}

cut_link() {
  step "A cable is pulled and plugged in again: what runs there runs on"
  local before
  before=$(pid_of map)
  say "the link of vision is cut"
  in_network "${network[switch]}" ip link set vision down
  local _
  for _ in {1..200}; do
    [[ $(history_of '[.[].message | select(test("What runs there runs on"))] | length > 0') == true ]] && break
    sleep 0.1
  done
  expect "the machine goes on in" Active "$(status .state)"
  in_network "${network[switch]}" ip link set vision up
  say "the link is back"
  all_active
  expect "the process of map" "$before" "$(pid_of map)"
  expect "starts of map" 1 "$(history_of '[.[].message | select(test("^map started on host"))] | length')"
}

reboot_host() {
  step "A computer loses its power and boots again: its modules are started, and driven to Active"
  power_off motion
  boot motion
  await_host motion
  local _
  for _ in {1..300}; do
    [[ $(history_of '[.[].message | select(test("^legs started on host"))] | length') == 2 ]] && break
    sleep 0.2
  done
  all_active
  expect "the history names the reboot" yes \
    "$(history_of '[.[].message | select(test("motion is reached, and has been booted again"))] | length > 0' | sed 's/true/yes/')"
}

upgrade() {
  step "An upgrade of three computers, of which one has no space: none changes. With space all do"
  make_version 1.1.0
  say "a recording fills the disk of vision"
  fallocate -l "$(($(df --output=avail -B1 "$disks/vision" | tail -n 1) - (2 << 20)))" "$disks/vision/recording"
  say "\$ musher deploy robot.toml --version 1.1.0 --key robot.key"
  musher deploy "$config" --version 1.1.0 --key "$machine/robot.key" > "$scratch/full.log" 2>&1
  expect "exit code of deploy" 1 $?
  expect "it names the computer" yes "$(grep -q "host vision (root@${address[vision]}): it needs" "$scratch/full.log" && echo yes)"
  expect "versions of the three" "1.0.0 1.0.0 1.0.0" "$(versions)"
  rm "$disks/vision/recording"
  say "\$ musher deploy robot.toml --version 1.1.0 --key robot.key --restart"
  musher deploy "$config" --version 1.1.0 --key "$machine/robot.key" --restart > "$scratch/upgrade.log" 2>&1
  expect "exit code of deploy" 0 $?
  expect "versions of the three" "1.1.0 1.1.0 1.1.0" "$(versions)"
  all_active
}

# beyond_brain KEY: of the actuators that are there without the brain: "arms 57, depth 116, …".
beyond_brain() {
  status "[.actuators | to_entries[] | select(.key | IN(\"${modules[brain]// /\",\"}\") | not) | \"\(.key) \(.value.$1)\"] | sort | join(\", \")"
}

# note_next_leader EPOCH: when the first status of a later epoch is received, in nanoseconds. A follower that finds no
# controller ends, and the next one may find the new leader.
note_next_leader() {
  local line _
  for _ in {1..20}; do
    while read -r line; do
      (($(jq -r '.epoch // 0' <<< "$line") > $1)) && { date +%s%N; return; }
    done < <(musher status --follow --json 2> /dev/null)
  done
}

fail_over() {
  step "The computer of the controller loses its power: its standby leads, and nothing rises"
  local pids states noting
  here=motion
  say "\$ ssh motion musher up --standby --detach robot.toml"
  musher_up --standby "$config" > "$scratch/standby.log" 2>&1
  expect "exit code of up" 0 $?
  expect "motion stands by" "a controller leads, or has led until just now" "$(status .standby.why_not_leading)"
  say "\$ ssh motion musher set LowPower hands"
  musher set LowPower hands > /dev/null
  expect "hands are held in LowPower: exit code" 0 $?
  pids=$(beyond_brain pid) states=$(beyond_brain state)
  note_next_leader "$(status .epoch)" > "$scratch/next_leader" &
  noting=$!
  sleep 1  # so that the follower has its first status
  say "the power of brain is cut"
  cut=$(date +%s%N)
  power_off brain
  wait "$noting"
  at_most "from the cut to the first status of the new leader" 10000 "$((($(< "$scratch/next_leader") - cut) / 1000000))" ms
  await '[.actuators[] | select(.presence == "present")] | length == 8'
  expect "each of the others is in the state that it had" yes "$([[ $(beyond_brain state) == "$states" ]] && echo yes)"
  # A request that comes at once waits until it is known that nothing answers on brain.
  musher_set LowPower
  expect "outcome, without what ran on brain" done-degraded "$(answer .outcome)"
  expect "the machine went on in" Active "$(on motion "'$bin/musher' history --json --journal '$journal'" | jq -r '[.entries[] | select(.event == "machine_adopted")] | last.arguments.state')"
  await '[.actuators[] | select(.presence == "present" and .state == "LowPower")] | length == 8'
  expect "actuators in LowPower" 8 "$(status '[.actuators[] | select(.state == "LowPower")] | length')"
  expect "each of them has the process that it had" yes "$([[ $(beyond_brain pid) == "$pids" ]] && echo yes)"
}

return_of_brain() {
  step "That computer boots again: the new leader starts its modules, and no second controller comes up"
  boot brain
  await_host brain
  await '[.actuators[] | select(.state == "LowPower" and .degraded == false)] | length == 11'
  expect "actuators in LowPower" 11 "$(status '[.actuators[] | select(.state == "LowPower")] | length')"
  here=brain
  say "\$ ssh brain musher up --detach robot.toml"
  musher_up "$config" > "$scratch/second.log" 2>&1
  expect "exit code of up" 2 $?
  here=motion
  expect "units on brain" 3 "$(units_on brain)"
  expect "units on motion" 4 "$(units_on motion)"
  expect "units on vision" 4 "$(units_on vision)"
}

switch_off() {
  step "The machine is torn down on all computers"
  say "\$ musher down"
  musher down > "$scratch/down.log" 2>&1
  expect "exit code of down" 0 $?
  expect "units that are left on brain" 0 "$(on brain "systemctl list-units --all --no-legend 'musher-*'" | wc -l)"
  expect "units that are left on motion" 0 "$(on motion "systemctl list-units --all --no-legend 'musher-*'" | wc -l)"
  expect "units that are left on vision" 0 "$(on vision "systemctl list-units --all --no-legend 'musher-*'" | wc -l)"
}

draw() {
  step "The picture: what ran where, and who led"
  local host
  for host in brain motion; do
    printf '%s ' "$host"
    "$bin/musher" history --json --lines 0 --journal "$disks/$host/state/journal.sqlite" 2> /dev/null
  done | python3 "$root/scripts/demos/host_timeline" "$picture" --off "brain=${cut:0:-9}.${cut: -9}" \
    "brain=${modules[brain]// /,}" "motion=${modules[motion]// /,}" "vision=${modules[vision]// /,}"
  expect "exit code" 0 $?
  say "$picture"
}

run_demo() {
  start_up
  kill_one
  eat_memory
  cut_link
  reboot_host
  upgrade
  fail_over
  return_of_brain
  switch_off
  draw
}
