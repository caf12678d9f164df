within WiperDrive;
package Loads "Loads of the output shaft and of the rockers"
end Loads;
