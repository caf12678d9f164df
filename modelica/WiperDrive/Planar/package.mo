within WiperDrive;
package Planar "Bars and joints in the plane, the linkage"
end Planar;
