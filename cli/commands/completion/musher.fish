# fish completion for musher: the program itself prints the completions.

# Files with this ending and folders; without one: all files. Of --option=FILE the part behind the '='.
function __musher_files -a ending
    set -l option (string match -r -- '^-[^=]*=' (commandline -ct))
    set -l begin (string replace -- "$option" '' (commandline -ct))
    complete -C "'' $begin" | string replace -r -- '\t.*' '' | string match -r -- ".*(?:/|$ending)\$" | string replace -r -- '^' "$option"
end

function __musher_complete
    set -l words (commandline -opc) (commandline -ct)
    set -l program $words[1]
    type -q -- $program; or set program musher
    $program complete $words[2..] 2>/dev/null | while read -l line
        switch $line
            case ':configs'
                __musher_files '\.toml'
            case ':trees'
                __musher_files '\.xml'
            case ':files'
                __musher_files ''
            case ':folders'
                __musher_files /
            case '*'
                echo $line
        end
    end
end

complete -c musher -f -a '(__musher_complete)'
