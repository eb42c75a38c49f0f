# bash completion for musher: the program itself prints the completions.

_musher_files() {
  local file
  while read -r file; do
    [[ $file == *' '* ]] && printf -v file %q "$file"
    COMPREPLY+=("$file")
  done < <(compgen "$@" | sort)
}

_musher() {
  local program=${1:-musher} current=${COMP_WORDS[COMP_CWORD]} line IFS=$'\n'
  type -P "$program" >/dev/null || program=musher
  # After the '=' of --option=value bash completes the value alone.
  [[ $current == '=' ]] && current=
  COMPREPLY=()
  while read -r line; do
    case $line in
      :configs)
        _musher_files -f -X '!*.toml' -- "$current"
        _musher_files -d -S / -- "$current" ;;
      :trees)
        _musher_files -f -X '!*.xml' -- "$current"
        _musher_files -d -S / -- "$current" ;;
      :files) _musher_files -f -- "$current" ;;
      :folders) _musher_files -d -S / -- "$current" ;;
      *) COMPREPLY+=("${line%%$'\t'*}") ;;
    esac
  done < <("$program" complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
  # Words end in a space, folders and KEY= do not.
  local i
  for i in "${!COMPREPLY[@]}"; do
    [[ ${COMPREPLY[i]} == *[/=] ]] || COMPREPLY[i]+=" "
  done
}

complete -o nospace -o bashdefault -F _musher musher
