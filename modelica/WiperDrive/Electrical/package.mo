within WiperDrive;
package Electrical "Electrical components, the bridge and the motor"
end Electrical;
