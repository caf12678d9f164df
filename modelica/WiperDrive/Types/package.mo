within WiperDrive;
package Types "SI types: every variable of the library has one of them"
end Types;
