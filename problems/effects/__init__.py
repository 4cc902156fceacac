"""Physical causes that a rotor model may lack, one file each."""
