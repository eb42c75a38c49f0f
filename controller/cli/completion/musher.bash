# bash completion for musher: commands, options, states, files.

_musher() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]}
  local commands="check up down status capabilities set restart estop wake keep low-power poweroff reboot plan history behavior replay simulate graph keys ota completion"
  local options="--help --json --namespace --domain --transport --timeout --keys --identity --color"
  local states="SelfCheck Active DeActive Protected LowPower OTA Error TearDown"
  COMPREPLY=()

  case $prev in
    --transport) COMPREPLY=($(compgen -W "local lan" -- "$cur")); return ;;
    --color) COMPREPLY=($(compgen -W "auto always never" -- "$cur")); return ;;
    --format) COMPREPLY=($(compgen -W "dot mermaid svg" -- "$cur")); return ;;
    --what) COMPREPLY=($(compgen -W "flow actuators" -- "$cur")); return ;;
    --keys | --root | --out | --from) COMPREPLY=($(compgen -d -S / -- "$cur")); return ;;
    --role) COMPREPLY=($(compgen -W "controller actuator operator observer" -- "$cur")); return ;;
    --why | --home) COMPREPLY=($(compgen -W "$states" -- "$cur")); return ;;
    --output | -o | --journal | --config | --svg | --key) COMPREPLY=($(compgen -f -- "$cur")); return ;;
    --namespace | --domain | --timeout | --for | --identity | --days | --since | --limit | --history | --behavior | --epoch | --seeds | --seed | --only | --bound | --jobs | -j | --min-version | --robot) return ;;
  esac

  local command="" word
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    if [[ " $commands " == *" $word "* ]]; then
      command=$word
      break
    fi
  done

  case $command in
    "") options+=" --version" ;;
    up) options+=" --detach --takeover --adopt --restarted" ;;
    down) options+=" --without-controller" ;;
    status) options+=" --watch" ;;
    estop) options+=" --release" ;;
    keep) options+=" --for --end" ;;
    low-power) options+=" --this-run" ;;
    history) options+=" --since --until --actuator --limit --csv --follow --journal --why" ;;
    behavior) options+=" --history --watch --send" ;;
    replay) options+=" --config --since --epoch" ;;
    simulate) options+=" --seeds --seed --only --bound --home --svg --jobs" ;;
    graph) options+=" --what --behavior --format --output" ;;
    keys) options+=" --role --days --signed-only --force" ;;
    ota) options+=" --root --key --version --min-version --robot --config --out --from --allow-downgrade" ;;
  esac
  if [[ $cur == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$cur"))
    return
  fi

  case $command in
    "") COMPREPLY=($(compgen -W "$commands" -- "$cur")) ;;
    ota)
      case $prev in
        ota) COMPREPLY=($(compgen -W "keygen bundle init verify install status rollback" -- "$cur")) ;;
        *) COMPREPLY=($(compgen -d -S / -- "$cur")) ;;
      esac ;;
    check | up | simulate | graph) COMPREPLY=($(compgen -f -X '!*.toml' -- "$cur") $(compgen -d -S / -- "$cur")) ;;
    keys)
      case $prev in
        keys) COMPREPLY=($(compgen -W "init add revoke list" -- "$cur")) ;;
        init) COMPREPLY=($(compgen -f -X '!*.toml' -- "$cur") $(compgen -d -S / -- "$cur")) ;;
      esac ;;
    replay) COMPREPLY=($(compgen -f -- "$cur")) ;;
    low-power) COMPREPLY=($(compgen -W "on off" -- "$cur")) ;;
    keep | set | plan) COMPREPLY=($(compgen -W "$states" -- "$cur")) ;;
    completion) COMPREPLY=($(compgen -W "bash zsh" -- "$cur")) ;;
  esac
}

complete -o nospace -o bashdefault -F _musher_with_space musher

# Words end in a space, folders do not.
_musher_with_space() {
  _musher
  local i
  for i in "${!COMPREPLY[@]}"; do
    [[ ${COMPREPLY[i]} == */ ]] || COMPREPLY[i]+=" "
  done
}
