within WiperDrive;
package Systems "Complete models: the plants and the closed loop"
end Systems;
