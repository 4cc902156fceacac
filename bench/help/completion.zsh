# Completion of ksmea-bench, ksmea and `python -m bench` for zsh.
# In ~/.zshrc, behind compinit: eval "$(ksmea-bench completion zsh)"
_ksmea_bench() {
    local -a program given replies files
    given=("${(@Q)words[2,CURRENT]}")
    program=("${(@Q)words[1]}")
    if [[ ${words[1]} == *python* ]]; then
        # Not this program: what zsh would have done.
        if [[ ${words[2]} != -m || ${words[3]} != bench ]]; then
            (( $+functions[_python] )) && _python || _default
            return
        fi
        program=("${(@Q)words[1,3]}")
        given=("${(@Q)words[4,CURRENT]}")
    fi
    replies=("${(@f)$("${program[@]}" _complete "${given[@]}" 2>/dev/null)}")
    replies=("${(@)replies:#}")
    if (( ${replies[(Ie)<files>]} )); then
        replies=("${(@)replies:#<files>}")
        compset -P '*[=,\[]'
        _files
    fi
    files=("${(@M)replies:#*[=.,]}")
    replies=("${(@)replies:#*[=.,]}")
    (( ${#files} )) && compadd -S '' -- "${files[@]}"
    (( ${#replies} )) && compadd -- "${(@)replies% }"
}
compdef _ksmea_bench ksmea-bench ksmea python python3
