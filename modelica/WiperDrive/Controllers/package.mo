within WiperDrive;
package Controllers "Sampled controllers"
end Controllers;
