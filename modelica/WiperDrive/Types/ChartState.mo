within WiperDrive.Types;
type ChartState = enumeration(
    IDLE "Motor off",
    Soft_start "Ramp up to full voltage",
    RUN "Full voltage (RUN.RUN)",
    turn_point_dec "Ramp down towards a turning point (RUN.turn_point_dec)",
    turn_point_acc "Ramp up after a turning point (RUN.turn_point_acc)",
    Soft_stop "Ramp down at the end of a revolution") "States of the voltage profile, figure 3.11";
