within WiperDrive;
package Rotational "Rotation about fixed axes"
end Rotational;
