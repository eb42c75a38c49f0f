# fish completion for musher: the program itself prints the completions.

function __musher_complete
    set -l words (commandline -opc) (commandline -ct)
    set -l program $words[1]
    type -q -- $program; or set program musher
    $program complete $words[2..] 2>/dev/null | while read -l line
        switch $line
            case ':configs'
                __fish_complete_suffix .toml
            case ':trees'
                __fish_complete_suffix .xml
            case ':files'
                __fish_complete_path (commandline -ct)
            case ':folders'
                __fish_complete_directories (commandline -ct)
            case '*'
                echo $line
        end
    end
end

complete -c musher -f -a '(__musher_complete)'
