# bash completion for musher: the program itself prints the completions.

# The shell writes names of files: with quotes where they need them, and a space or a slash behind.
_musher_files() {
  compopt -o filenames +o nospace 2>/dev/null
  mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen "$@")
}

_musher() {
  local program=${1:-musher} current=${COMP_WORDS[COMP_CWORD]} line
  type -P "$program" >/dev/null || program=musher
  # After the '=' of --option=value bash completes the value alone.
  [[ $current == '=' ]] && current=
  COMPREPLY=()
  while read -r line; do
    case $line in
      :configs)
        _musher_files -f -X '!*.toml' -- "$current"
        _musher_files -d -- "$current" ;;
      :trees)
        _musher_files -f -X '!*.xml' -- "$current"
        _musher_files -d -- "$current" ;;
      :files) _musher_files -f -- "$current" ;;
      :folders) _musher_files -d -- "$current" ;;
      *=$'\t'*) COMPREPLY+=("${line%%$'\t'*}") ;;
      *) COMPREPLY+=("${line%%$'\t'*} ") ;;
    esac
  done < <("$program" complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
}

complete -o nospace -o bashdefault -F _musher musher
