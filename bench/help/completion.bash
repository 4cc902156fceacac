# Completion of ksmea-bench, ksmea and `python -m bench` for bash 4 and newer.
# In ~/.bashrc: eval "$(ksmea-bench completion bash)"
_ksmea_bench() {
    local line=${COMP_LINE:0:COMP_POINT} program=(ksmea-bench) words=() word current i
    # Bash has split the words at = and :, so they are put together again as they were typed.
    for ((i = 0; i <= COMP_CWORD; i++)); do
        word=${COMP_WORDS[i]}
        if ((${#words[@]})) && [[ ${COMP_WORDS[i]} == [=:]* || ${COMP_WORDS[i-1]} == *[=:] ]] &&
            [[ $line == *"${words[-1]}$word"* ]]; then
            words[-1]+=$word
        else
            words+=("$word")
        fi
    done
    if [[ ${words[0]} == *python* ]]; then
        # Not this program: names of files, as without a completion.
        [[ ${words[1]} == -m && ${words[2]} == bench ]] || return
        program=("${words[0]}" -m bench)
        words=("${words[@]:3}")
    else
        program=("${words[0]}")
        words=("${words[@]:1}")
    fi
    ((${#words[@]})) || return
    current=${words[-1]}
    # The reply replaces what stands behind the last = or : alone.
    local kept=${current%"${current##*[=:]}"} reply
    # A file in a list has what stands before it there in front: plugins=[one.py,two.py
    local stem=${current##*[=:,[]}
    local lead=${current#"$kept"}
    lead=${lead%"$stem"}
    COMPREPLY=()
    while IFS= read -r reply; do
        if [[ $reply == "<files>" ]]; then
            compopt -o filenames 2>/dev/null
            while IFS= read -r word; do COMPREPLY+=("$lead$word"); done < <(compgen -f -- "$stem")
        elif [[ -n $reply ]]; then
            reply=${reply#"$kept"}
            [[ $reply == *[=.,] ]] && compopt -o nospace 2>/dev/null
            COMPREPLY+=("${reply% }")
        fi
    done < <("${program[@]}" _complete "${words[@]}" 2>/dev/null)
}
complete -o bashdefault -o default -F _ksmea_bench ksmea-bench ksmea python python3
